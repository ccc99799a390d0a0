// SPDX-License-Identifier: Apache-2.0
// Ranges of the values that colors stand for, over all runs together.
import type { Scene, Vec3 } from '../scene/scene';
import { joinRanges, robustRange, type Range } from './colors';
import { ageOf } from './points_layer';
import type { RangeName } from './style';

const samples = 20000;

export function rangesOf(scenes: Scene[], up: Vec3): Record<RangeName, Range | null> {
  const join = (values: (scene: Scene) => Iterable<number>) => joinRanges(scenes.map((s) => robustRange(values(s))));
  return {
    height: join((s) => heights(s, up)),
    age: join(pointAges),
    uncertainty: join(pointSigmas),
    error: join((s) => thinned(s.frames?.errors)),
    sigma: join((s) => thinned(s.frames?.sigmas)),
    time: join((s) => (s.frames ? [0, s.frames.stamps[s.frames.count - 1] - s.frames.stamps[0]] : [])),
  };
}

function* sampled(count: number): Generator<number> {
  const step = Math.max(1, Math.floor(count / samples));
  for (let i = 0; i < count; i += step) yield i;
}

function* thinned(values: Float32Array | null | undefined): Generator<number> {
  for (const i of sampled(values?.length ?? 0)) yield values![i];
}

function* heights(scene: Scene, up: Vec3): Generator<number> {
  for (const layer of scene.layers) {
    const at = layer.kind === 'points' || layer.kind === 'mesh' ? layer.positions : layer.kind === 'cubes' ? layer.centers : null;
    if (!at) continue;
    for (const i of sampled(at.length / 3)) yield at[3 * i] * up[0] + at[3 * i + 1] * up[1] + at[3 * i + 2] * up[2];
  }
}

function* pointAges(scene: Scene): Generator<number> {
  for (const layer of scene.layers) {
    if (layer.kind !== 'points' || !layer.keyframes || !scene.keyframes) continue;
    for (const i of sampled(layer.count)) yield ageOf(layer.keyframes[i], scene.keyframes);
  }
}

function* pointSigmas(scene: Scene): Generator<number> {
  for (const layer of scene.layers) {
    if (layer.kind !== 'points' || !layer.sigmas) continue;
    for (const i of sampled(layer.count)) yield layer.sigmas[i];
  }
}
