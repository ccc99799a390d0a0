// SPDX-License-Identifier: Apache-2.0
// All that can be clicked to measure: whatever is shown of points, surfaces, occupied cells, keyframes, trajectory.
import type { App } from '../app';
import type { GridLayer, Layer } from '../scene/scene';
import type { PointsLayer } from '../view3d/points_layer';
import type { Run } from '../view3d/run';
import type { Candidates } from './pick';

const occupiedFrom = 165; // of 254; the usual limit of 65 percent

const cellCache = new WeakMap<GridLayer, Float32Array>();

export function shownCandidates(app: App): Candidates[] {
  return app.runs.filter((run) => run.group.visible).flatMap((run) => ofRun(app, run));
}

function ofRun(app: App, run: Run): Candidates[] {
  const shown = new Set(run.layers.filter((l) => l.object.visible).map((l) => l.key));
  const { frames, keyframes, layers } = run.scene;
  const result: Candidates[] = [];
  const add = (source: string, positions: Float32Array, stride: number, sigmas: Float32Array | null, maxSigma = Infinity, surface = false) =>
    result.push({ source, run: run.index, positions, stride, sigmas, maxSigma, surface });
  if (frames && shown.has('trajectory:final')) add('trajectory', frames.positions, 3, frames.sigmas);
  if (keyframes && shown.has('keyframes')) add('keyframes', keyframes.poses, 7, null);
  // Layers of the scene are the last of the run's layers, in the same order.
  const objects = run.layers.slice(run.layers.length - layers.length);
  layers.forEach((layer, i) => {
    if (layer.kind === 'points') return (shown.has(objects[i].key) ? (objects[i] as PointsLayer).shown : []).forEach((data) => add(layer.name, data.positions, 3, data.sigmas, app.state.maxSigma, true));
    const positions = objects[i].object.visible ? positionsOf(layer) : null;
    if (positions) add(layer.name, positions, 3, null, app.state.maxSigma, layer.kind !== 'cubes');
  });
  return result;
}

function positionsOf(layer: Layer): Float32Array | null {
  switch (layer.kind) {
    case 'mesh':
      return layer.positions;
    case 'cubes':
      return layer.centers;
    case 'grid':
      return occupiedCells(layer);
    default:
      return null;
  }
}

function occupiedCells(grid: GridLayer): Float32Array {
  let cells = cellCache.get(grid);
  if (!cells) {
    const points: number[] = [];
    grid.cells.forEach((cell, i) => {
      if (cell === 255 || cell < occupiedFrom) return;
      points.push(grid.origin[0] + ((i % grid.width) + 0.5) * grid.cell, grid.origin[1] + (Math.floor(i / grid.width) + 0.5) * grid.cell, 0);
    });
    cells = Float32Array.from(points);
    cellCache.set(grid, cells);
  }
  return cells;
}
