// SPDX-License-Identifier: Apache-2.0
// Says what is not there, so that nobody searches for a switch or takes an empty view for a fault.
import type { Layer, Scene } from '../scene/scene';

export function missingParts(scenes: Scene[], live: boolean): string[] {
  if (scenes.length === 0) return [];
  if (live && scenes.every(isMapless)) return ['The run has no map yet.'];
  const what = scenes.length > 1 ? 'These maps have' : 'This map has';
  const parts: string[] = [];
  const holds = (kind: Layer['kind']) => scenes.some((s) => s.layers.some((l) => l.kind === kind && l.count > 0));
  if (!scenes.some((s) => s.frames)) parts.push(`${what} no trajectory.`);
  if (!scenes.some((s) => s.keyframes)) parts.push(`${what} no keyframes.`);
  if (!holds('points') && !holds('mesh') && !holds('cubes') && !holds('grid')) parts.push(`${what} no points.`);
  return parts;
}

/** Of a run that goes on and has not told its first map. */
export function isMapless(scene: Scene): boolean {
  return scene.revision === null && !scene.keyframes && scene.layers.length === 0;
}

export function isEmpty(scene: Scene): boolean {
  return !scene.frames && !scene.keyframes && scene.lengths.length === 0 && scene.layers.every((l) => l.count === 0);
}
