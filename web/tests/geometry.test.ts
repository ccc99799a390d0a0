// SPDX-License-Identifier: Apache-2.0
// Measuring, color maps, the timeline's arithmetic and the address: all without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { asPoint, featureAt, spanBetween, type Feature } from '../src/measure/feature';
import { scaled, scaleFrom } from '../src/measure/length';
import { pick, type Candidates } from '../src/measure/pick';
import { withSigma } from '../src/measure/texts';
import { initialState } from '../src/initial_state';
import type { Frames, Vec3 } from '../src/scene/scene';
import { fromHash, toHash, withinRuns } from '../src/state';
import { columnMaxima, duration, frameAt, nearestFrame, stretches, timeStep } from '../src/timeline/track';
import { mapBytes, mapColor, robustRange, stateColor } from '../src/view3d/colors';
import { niceStep } from '../src/view3d/reference';
import { random } from './scene_writer';

const at = (point: Vec3, sigma: number | null) => asPoint({ point, sigma, source: 'cloud', run: 0, spacing: null }, 1);
const lengthBetween = (a: Feature, b: Feature, scaleSigma: number | null) => {
  const { length, sigma } = spanBetween(a, b, scaleSigma)!;
  return { length, sigma };
};

test('length and sigma of two points', () => {
  assert.deepEqual(lengthBetween(at([0, 0, 0], 0.003), at([1, 2, 2], 0.004), null), { length: 3, sigma: 0.005 });
  assert.equal(lengthBetween(at([0, 0, 0], null), at([1, 0, 0], 0.1), null).sigma, null);
  const withScale = lengthBetween(at([0, 0, 0], 0.03), at([4, 0, 0], 0), 0.01);
  assert.ok(Math.abs(withScale.sigma! - 0.05) < 1e-12);
});

/** A board of 0.75 by 0.3 m, 12 mm apart points with 2 mm of noise, in front of a wall. */
function board(): Candidates {
  const noise = random(3);
  const positions: number[] = [];
  for (let x = 0; x <= 0.75; x += 0.012) for (let y = 0; y <= 0.3; y += 0.012) positions.push(x, y, 0.004 * (noise() - 0.5));
  for (let x = -0.5; x <= 1.25; x += 0.02) for (let y = -0.5; y <= 0.8; y += 0.02) positions.push(x, y, 0.4 + 0.004 * (noise() - 0.5));
  return candidates(positions);
}

test('two edges of a board, and its distance from the wall, within their error bars', () => {
  const around = { candidates: [board()], radius: 0.1, perPixel: 0.002, metric: true, upright: null };
  const take = (kind: 'edge' | 'face', point: Vec3) => featureAt(kind, { point, sigma: null, source: 'cloud', run: 0, spacing: null }, around)!;
  const [left, right] = [take('edge', [0.012, 0.132, 0]), take('edge', [0.744, 0.156, 0])];
  assert.ok(Math.abs(Math.abs(left.direction![1]) - 1) < 0.01, `${left.direction}`);
  const width = spanBetween(left, right, null)!;
  assert.ok(Math.abs(width.length - 0.75) < 0.008 && width.sigma! > 0.01 && width.sigma! < 0.03, `${width.length} ± ${width.sigma}`);
  const depth = spanBetween(take('face', [0.36, 0.144, 0]), take('face', [-0.2, 0.6, 0.4]), null)!;
  assert.ok(Math.abs(depth.length - 0.4) < 0.002 && depth.sigma! < 0.006, `${depth.length} ± ${depth.sigma}`);
  assert.ok(Math.abs(depth.a[2] - depth.b[2] + 0.4) < 0.01);
  // Not parallel: an edge that runs up and one that runs across.
  assert.equal(spanBetween(left, take('edge', [0.36, 0.288, 0]), null), null);
  assert.equal(featureAt('edge', { point: [0.36, 0.144, 0], sigma: null, source: 'cloud', run: 0, spacing: null }, { ...around, radius: 0.05 }), null);
});

test('a known length gives the scale and its sigma', () => {
  const scale = scaleFrom({ length: 2, sigma: 0.02 }, 5)!;
  assert.deepEqual(scale, { factor: 2.5, sigma: 0.01 });
  const other = scaled({ length: 4, sigma: 0.03 }, scale);
  assert.equal(other.length, 10);
  assert.ok(Math.abs(other.sigma! - 2.5 * 0.05) < 1e-12);
  assert.equal(scaleFrom({ length: 0, sigma: null }, 1), null);
  assert.equal(scaleFrom({ length: 1, sigma: null }, -1), null);
});

test('lengths as text', () => {
  assert.equal(withSigma({ length: 1, sigma: 0.005 }, 'm'), '1.000 ± 0.005 m');
  assert.equal(withSigma({ length: 0.7512, sigma: 0.0123 }, 'm'), '0.751 ± 0.012 m');
  assert.equal(withSigma({ length: 2.5, sigma: null }, 'units'), '2.5 units ± unknown');
});

/** Looks along -z from z = 10 without perspective in x and y: clip = (x, y, ?, 10 - z). */
const view = { matrix: [10, 0, 0, 0, 0, 10, 0, 0, 0, 0, 1, -1, 0, 0, 0, 10], width: 200, height: 100 };

function candidates(positions: number[], maxSigma = Infinity, sigmas: number[] | null = null): Candidates {
  return { source: 'cloud', run: 0, positions: Float32Array.from(positions), stride: 3, sigmas: sigmas && Float32Array.from(sigmas), maxSigma, surface: true };
}

test('the point nearest on the screen is picked, of equal ones the foremost', () => {
  const points = candidates([0, 0, 0, 0.5, 0, 0, 0, 0, 5, 0, 0, 20]);
  assert.deepEqual(pick([points], view, 150, 50, 10)!.point, [0.5, 0, 0]);
  assert.deepEqual(pick([points], view, 100, 50, 10)!.point, [0, 0, 5]);
  assert.equal(pick([points], view, 20, 20, 10), null);
});

test('what is seen between the points of a surface is not picked', () => {
  const surface = Array.from({ length: 81 }, (_, i) => [0.02 * ((i % 9) - 4) + 0.01, 0.02 * (Math.floor(i / 9) - 4) + 0.01, 5]).flat();
  assert.equal(pick([candidates([...surface, 0, 0, 0])], view, 100, 50, 10)!.point[2], 5);
});

test('beside the end of a surface its own points are picked, not what is nearer on the screen behind it', () => {
  const surface = Array.from({ length: 81 }, (_, i) => [0.02 * (i % 9) - 0.2, 0.02 * (Math.floor(i / 9) - 4), 5]).flat();
  assert.equal(pick([candidates([...surface, 0, 0, 0])], view, 100, 50, 10)!.point[2], 5);
  const alone = { ...candidates([...surface, 0, 0, 0]), surface: false };
  assert.equal(pick([alone], view, 100, 50, 10)!.point[2], 0, 'points that stand alone hide nothing beside them');
});

test('hidden points and points that are not numbers are not picked', () => {
  assert.equal(pick([candidates([0, 0, 0], 0.1, [0.2])], view, 100, 50, 10), null);
  assert.equal(pick([candidates([NaN, 0, 0])], view, 100, 50, 10), null);
  assert.equal(pick([candidates([0, 0, 0], Infinity, [NaN])], view, 100, 50, 10)!.sigma, null);
});

test('color maps have their published ends and are clamped', () => {
  const rgb = (color: number[]) => color.map((v) => Math.round(v * 255));
  assert.deepEqual(rgb(mapColor('viridis', 0)), [0x44, 0x01, 0x54]);
  assert.deepEqual(rgb(mapColor('viridis', 2)), [0xfd, 0xe7, 0x25]);
  assert.deepEqual(rgb(mapColor('cividis', 1)), [0xff, 0xea, 0x46]);
  assert.deepEqual(rgb(mapColor('viridis', NaN)), [0x8f, 0x8f, 0x8f]);
  assert.equal(stateColor('constructor'), '#8f8f8f');
});

test('color maps grow brighter from end to end, as color-blind people need', () => {
  for (const map of ['viridis', 'cividis'] as const) {
    const bytes = mapBytes(map);
    let last = -1;
    for (let i = 0; i < 256; i++) {
      const light = 0.2126 * bytes[4 * i] + 0.7152 * bytes[4 * i + 1] + 0.0722 * bytes[4 * i + 2];
      assert.ok(light >= last - 0.6, `${map} at ${i}`);
      last = light;
    }
  }
});

test('ranges leave out outliers and what is not a number', () => {
  assert.deepEqual(robustRange([3, NaN, 1, 2]), [1, 3]);
  assert.equal(robustRange([NaN]), null);
  const many = Array.from({ length: 1000 }, (_, i) => i);
  assert.deepEqual(robustRange([...many, 1e9]), [20, 980]);
});

function frames(stamps: number[], states: number[]): Frames {
  const n = stamps.length;
  return {
    count: n, stamps: Float64Array.from(stamps), positions: new Float32Array(3 * n), orientations: new Float32Array(4 * n),
    online: null, states: Uint8Array.from(states), sigmas: null, errors: null, truth: null, milliseconds: null,
  };
}

test('stretches of one state, broken at gaps of the recording', () => {
  const result = stretches(frames([0, 0.5, 1, 1.5, 30], [0, 0, 2, 0, 0]));
  assert.deepEqual(result.map((s) => [s.from, s.to, s.state]), [[0, 1, 0], [1, 1.5, 2], [1.5, 1.5, 0], [30, 30, 0]]);
});

test('frames by stamp', () => {
  const stamps = Float64Array.from([0, 1, 2, 5]);
  assert.deepEqual([-1, 0, 1.9, 2, 4, 9].map((s) => frameAt(stamps, s)), [0, 0, 1, 2, 2, 3]);
  assert.deepEqual([1.4, 1.6, 3.4, 3.6].map((s) => nearestFrame(stamps, s)), [1, 2, 2, 3]);
});

test('the curve keeps the largest value of each column', () => {
  const f = frames([0, 1, 2, 3, 4], [0, 0, 0, 0, 0]);
  assert.deepEqual([...columnMaxima(f, Float32Array.from([1, 5, 2, NaN, 3]), 2)], [5, 3]);
});

test('durations and steps are readable', () => {
  assert.equal(duration(3.2), '3.20 s');
  assert.equal(duration(125.14), '2:05.1');
  assert.equal(duration(119.98), '1:59.9');
  assert.equal(duration(3725), '1:02:05');
  assert.equal(timeStep(100, 10), 10);
  assert.deepEqual([0.3, 1, 1.5, 7].map(niceStep), [0.5, 1, 2, 10]);
});

test('the address holds the state and gives it back', () => {
  const initial = initialState([], 10);
  assert.equal(toHash(initial, initial), '');
  const state = { ...initial, layers: { 'points:cloud': false, 'trajectory:online': true }, hiddenRuns: [1], frame: 17, pointColor: 'age' as const, maxSigma: 0.05, camera: [1, 2, 3, 0, 0, 0.5], theme: 'dark' as const };
  assert.deepEqual(fromHash(`#${toHash(state, initial)}`, initial), state);
  assert.deepEqual(fromHash('#frame=x&points=none&view=1,2&layers=%00&size=-3', initial), { ...initial, pointSize: 1 });
});

test('an address with values beyond the runs gives their ends', () => {
  const initial = initialState([], 10);
  const state = fromHash('#run=7&frame=9999&cameras=Infinity&frame=1e400', initial);
  assert.equal(state.cameraSize, initial.cameraSize);
  assert.equal(fromHash('#frame=1e400', initial).frame, 0);
  const within = withinRuns(state, [400, 20]);
  assert.deepEqual([within.active, within.frame], [1, 19]);
  assert.deepEqual([withinRuns(state, []).active, withinRuns(state, [0]).frame], [0, 0]);
});
