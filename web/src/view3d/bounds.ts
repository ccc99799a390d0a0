// SPDX-License-Identifier: Apache-2.0
// Where the content lies. A few points far away (wrong landmarks) must not make the view zoom out.
import * as THREE from 'three';
import type { Layer, Scene } from '../scene/scene';
import { corners } from './viewpoint';

const samples = 20000;

export function boundsOf(scenes: Scene[]): THREE.Box3 {
  const box = new THREE.Box3();
  for (const scene of scenes) {
    if (scene.frames) box.union(robustBox(scene.frames.positions, 3, 0));
    if (scene.keyframes) box.union(robustBox(scene.keyframes.poses, 7, 0));
    for (const layer of scene.layers) box.union(layerBox(layer));
    for (const length of scene.lengths) box.expandByPoint(new THREE.Vector3(...length.a)).expandByPoint(new THREE.Vector3(...length.b));
  }
  if (finite(box) && box.getSize(new THREE.Vector3()).length() < 1e-6) box.expandByScalar(1);
  return finite(box) ? box : new THREE.Box3(new THREE.Vector3(-1, -1, -1), new THREE.Vector3(1, 1, 1));
}

function finite(box: THREE.Box3): boolean {
  return !box.isEmpty() && [...box.min.toArray(), ...box.max.toArray()].every((v) => Math.abs(v) < 1e12);
}

function layerBox(layer: Layer): THREE.Box3 {
  switch (layer.kind) {
    case 'points':
    case 'mesh':
      return robustBox(layer.positions, 3, 0.01);
    case 'cubes':
    case 'ellipsoids':
      return robustBox(layer.centers, 3, 0.01);
    case 'grid':
      return gridBox(layer);
    case 'edges':
      return new THREE.Box3();
  }
}

function gridBox(grid: Extract<Layer, { kind: 'grid' }>): THREE.Box3 {
  // Only known cells count: maps often have a wide unknown border.
  const box = new THREE.Box2();
  const corner = new THREE.Vector2();
  for (let y = 0, i = 0; y < grid.height; y++) {
    for (let x = 0; x < grid.width; x++, i++) if (grid.cells[i] !== 255) box.expandByPoint(corner.set(x, y));
  }
  if (box.isEmpty()) return new THREE.Box3();
  const place = (v: number, axis: 0 | 1) => grid.origin[axis] + v * grid.cell;
  return new THREE.Box3(
    new THREE.Vector3(place(box.min.x, 0), place(box.min.y, 1), 0),
    new THREE.Vector3(place(box.max.x + 1, 0), place(box.max.y + 1, 1), 0),
  );
}

/** A sample of the content: the view is fitted to it more tightly than to the box, which may stand askew. */
export function outlineOf(scenes: Scene[], box: THREE.Box3): THREE.Vector3[] {
  const inside = box.clone().expandByScalar(1e-6 + 0.01 * box.getSize(new THREE.Vector3()).length());
  const sources = scenes.flatMap((scene) => scene.layers.flatMap((layer): [Float32Array, number][] => {
    if (layer.kind === 'points' || layer.kind === 'mesh') return [[layer.positions, 3]];
    return layer.kind === 'cubes' ? [[layer.centers, 3]] : [];
  }).concat(scene.frames ? [[scene.frames.positions, 3]] : [], scene.keyframes ? [[scene.keyframes.poses, 7]] : []));
  const grids = scenes.some((s) => s.layers.some((l) => l.kind === 'grid' && l.count > 0));
  const points = sources.flatMap(([values, stride]) => sampled(values, stride, 2000)).filter((p) => inside.containsPoint(p));
  return points.length < 2 || grids ? corners(box) : points;
}

function sampled(values: Float32Array, stride: number, count: number): THREE.Vector3[] {
  const rows = Math.floor(values.length / stride);
  const step = Math.max(1, Math.floor(rows / count));
  return Array.from({ length: Math.floor(rows / step) }, (_, i) => new THREE.Vector3().fromArray(values, i * step * stride));
}

/** Box of the rows without the share `cut` at either end of each axis. */
export function robustBox(values: Float32Array, stride: number, cut: number): THREE.Box3 {
  const rows = values.length / stride;
  const step = Math.max(1, Math.floor(rows / samples));
  const axes: number[][] = [[], [], []];
  for (let row = 0; row < rows; row += step) {
    const p = [values[row * stride], values[row * stride + 1], values[row * stride + 2]];
    if (p.every(Number.isFinite)) p.forEach((v, axis) => axes[axis].push(v));
  }
  if (axes[0].length === 0) return new THREE.Box3();
  const ends = axes.map((axis) => {
    const sorted = Float64Array.from(axis).sort();
    const skip = Math.floor(cut * sorted.length);
    return [sorted[skip], sorted[sorted.length - 1 - skip]];
  });
  return new THREE.Box3(
    new THREE.Vector3(ends[0][0], ends[1][0], ends[2][0]),
    new THREE.Vector3(ends[0][1], ends[1][1], ends[2][1]),
  );
}
