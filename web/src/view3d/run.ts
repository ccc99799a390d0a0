// SPDX-License-Identifier: Apache-2.0
// One scene as objects to draw: a run with its own color and a switch.
import * as THREE from 'three';
import type { Layer, Scene } from '../scene/scene';
import { runColors } from './colors';
import { EdgesLayer } from './edges_layer';
import { EllipsoidsLayer } from './ellipsoids_layer';
import { GridLayer } from './grid_layer';
import { KeyframesLayer } from './keyframes_layer';
import { PointsLayer } from './points_layer';
import type { LayerObject } from './style';
import { TiledPoints } from './tiled_points';
import { cubesLayer, meshLayer } from './surface_layers';
import { TrajectoryLayer, type TrajectoryKind } from './trajectory_layer';

export interface Run {
  index: number;
  name: string;
  scene: Scene;
  color: string;
  group: THREE.Group;
  layers: LayerObject[];
  /** It goes on. */
  live: boolean;
}

export function runColor(index: number): string {
  return runColors[index % runColors.length];
}

/** `trajectories` take the place of the scene's own while a run goes on. */
export function buildRun(name: string, scene: Scene, index: number, trajectories?: LayerObject[]): Run {
  const color = runColor(index);
  const layers: LayerObject[] = trajectories ? [...trajectories] : trajectoriesOf(scene, color);
  if (scene.keyframes) layers.push(new KeyframesLayer(scene.keyframes, scene.camera, color));
  for (const layer of scene.layers) layers.push(withUniqueKey(layerObject(layer, scene, color), layers));
  const group = new THREE.Group();
  for (const layer of layers) group.add(layer.object);
  return { index, name, scene, color, group, layers, live: trajectories !== undefined };
}

function trajectoriesOf({ frames, stateNames }: Scene, color: string): LayerObject[] {
  if (!frames) return [];
  const kinds: TrajectoryKind[] = ['final', 'online', 'truth'];
  return kinds.filter((kind) => kind === 'final' || frames[kind]).map((kind) => new TrajectoryLayer(kind, frames, stateNames, color));
}

/** Gives back what the graphics card holds for a run; layers in `kept` go on in another run. */
export function disposeRun(run: Run, kept: LayerObject[]): void {
  for (const layer of kept) run.group.remove(layer.object);
  run.group.traverse((object) => {
    const { geometry, material } = object as Partial<THREE.Mesh>;
    geometry?.dispose();
    for (const m of material ? [material].flat() : []) {
      (m as THREE.MeshBasicMaterial).map?.dispose();
      m.dispose();
    }
  });
}

function layerObject(layer: Layer, scene: Scene, color: string): LayerObject {
  switch (layer.kind) {
    case 'edges':
      return new EdgesLayer(layer, scene.keyframes);
    case 'points':
      return layer.tiles?.url ? new TiledPoints(layer, scene.keyframes, color) : new PointsLayer(layer, scene.keyframes, color);
    case 'mesh':
      return meshLayer(layer, color);
    case 'cubes':
      return cubesLayer(layer, color);
    case 'grid':
      return new GridLayer(layer);
    case 'ellipsoids':
      return new EllipsoidsLayer(layer);
  }
}

/** Two layers of one kind and name are switched apart. */
function withUniqueKey(layer: LayerObject, others: LayerObject[]): LayerObject {
  const same = others.filter((o) => o.key === layer.key || o.key.startsWith(`${layer.key}#`)).length;
  if (same > 0) Object.assign(layer, { key: `${layer.key}#${same + 1}`, label: `${layer.label} ${same + 1}` });
  return layer;
}
