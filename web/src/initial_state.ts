// SPDX-License-Identifier: Apache-2.0
// How the page begins for given scenes.
import type { Scene } from './scene/scene';
import type { State } from './state';
import type { PointColor, TrajectoryColor } from './view3d/style';

export function initialState(scenes: Scene[], contentSize: number): State {
  return {
    layers: {},
    hiddenRuns: [],
    active: 0,
    frame: 0,
    pointColor: pointColor(scenes),
    trajectoryColor: trajectoryColor(scenes),
    map: 'viridis',
    pointSize: pointSize(scenes),
    maxSigma: Infinity,
    cameraSize: cameraSize(scenes, contentSize),
    ellipsoidScale: 3,
    theme: 'auto',
    camera: null,
  };
}

function pointColor(scenes: Scene[]): PointColor {
  if (scenes.length > 1) return 'run';
  const colored = scenes.some((s) => s.layers.some((l) => 'colors' in l && l.colors !== null));
  return colored ? 'image' : scenes.every((s) => s.planar) ? 'run' : 'height';
}

function trajectoryColor(scenes: Scene[]): TrajectoryColor {
  if (scenes.length > 1) return 'run';
  return scenes[0]?.frames?.states ? 'state' : 'time';
}

/** Few points are drawn larger than many. */
function pointSize(scenes: Scene[]): number {
  const points = scenes.flatMap((s) => s.layers).reduce((sum, l) => sum + (l.kind === 'points' ? l.tiles?.count ?? l.count : 0), 0);
  if (scenes.every((s) => s.planar)) return 2;
  return points < 2e4 ? 4 : points < 5e5 ? 3 : 2;
}

/** About the usual distance between keyframes, so that drawn cameras neither vanish nor cover each other. */
function cameraSize(scenes: Scene[], contentSize: number): number {
  const steps: number[] = [];
  for (const { keyframes } of scenes) {
    for (let row = 1; row < (keyframes?.count ?? 0); row++) {
      const p = keyframes!.poses;
      steps.push(Math.hypot(p[7 * row] - p[7 * row - 7], p[7 * row + 1] - p[7 * row - 6], p[7 * row + 2] - p[7 * row - 5]));
    }
  }
  const usual = steps.filter((s) => s > 0 && Number.isFinite(s)).sort((a, b) => a - b);
  const step = usual.length ? usual[usual.length >> 1] : 0;
  return Math.min(0.03 * contentSize, Math.max(0.006 * contentSize, 0.6 * step));
}
