// SPDX-License-Identifier: Apache-2.0
// Reading scenes: exact values, plain messages, and nothing but SceneError for any damage.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { parseScene } from '../src/scene/parse';
import { SceneError } from '../src/scene/scene';
import { decodeBase64, tokenQuery } from '../src/scene/sources';
import { damaged } from './damage';
import { SceneWriter, random } from './scene_writer';
import { exactScene, floorScene, roomScene } from './scenes';

function fails(bytes: Uint8Array, message: RegExp): void {
  assert.throws(() => parseScene(bytes), (error) => error instanceof SceneError && message.test(error.message));
}

function withHeader(header: object, fill: (w: SceneWriter) => object = () => ({})): Uint8Array {
  const w = new SceneWriter();
  return w.finish({ ...header, ...fill(w) });
}

test('a room is read with all its parts', () => {
  const scene = parseScene(roomScene());
  assert.equal(scene.title, 'room');
  assert.equal(scene.frames!.count, 400);
  assert.equal(scene.frames!.stamps[30], 1001);
  assert.equal(scene.keyframes!.count, 40);
  assert.deepEqual(scene.layers.map((l) => l.kind), ['edges', 'edges', 'edges', 'points', 'mesh', 'cubes', 'ellipsoids']);
  assert.deepEqual([...scene.up], [0, -1, 0]);
  assert.equal(scene.lengths[0].sigma, 0.006);
  assert.deepEqual(scene.events.map((e) => e.frame), [165, 180, 395]);
});

test('arrays are views into the bytes and hold the exact numbers', () => {
  const bytes = exactScene();
  const layer = parseScene(bytes).layers[0];
  assert.equal(layer.kind, 'points');
  if (layer.kind !== 'points') return;
  assert.equal(layer.positions.buffer, bytes.buffer);
  assert.deepEqual([...layer.positions.subarray(12)], [0.5, 1, 0.75]);
  assert.deepEqual([...layer.colors!.subarray(0, 3)], [255, 0, 0]);
});

test('a scene at an odd place of a buffer is read as well', () => {
  const bytes = floorScene();
  const shifted = new Uint8Array(bytes.length + 3);
  shifted.set(bytes, 3);
  const grid = parseScene(shifted.subarray(3)).layers[0];
  assert.equal(grid.kind === 'grid' && grid.cells.length, 240 * 160);
});

test('a scene without any part is empty, not wrong', () => {
  const scene = parseScene(withHeader({}));
  assert.equal(scene.frames, null);
  assert.deepEqual(scene.layers, []);
  assert.deepEqual(scene.up, [0, 0, 1]);
});

test('messages name what is wrong', () => {
  fails(new Uint8Array(3), /only 3 bytes/);
  fails(roomScene().subarray(0, 200), /header of the scene is cut off/);
  fails(roomScene().subarray(0, 20000), /reaches past the end/);
  fails(withHeader({ format: 'ply' }), /not a scene of rastro/);
  fails(withHeader({ version: 2 }), /has version 2, this page reads version 1/);
  fails(withHeader({ up: [0, 0, 0] }), /up has no direction/);
  fails(withHeader({ layers: [{ kind: 'smoke', name: 'x' }] }), /layers\[0\].kind is smoke/);
  fails(withHeader({ layers: {} }), /layers is not a list/);
});

test('indices and counts that do not fit are refused', () => {
  fails(withHeader({}, (w) => ({ layers: [{ kind: 'edges', name: 'e', pairs: w.u32([0, 1]) }] })), /index 0, but there are only 0 rows/);
  fails(withHeader({}, (w) => ({ layers: [{ kind: 'mesh', name: 'm', positions: w.f32([0, 0, 0]), triangles: w.u32([0, 0, 1]) }] })), /index 1/);
  fails(withHeader({}, (w) => ({ layers: [{ kind: 'points', name: 'p', positions: w.f32([0, 0, 0]), sigmas: w.f32([1, 2]) }] })), /has 2 rows where 1 are needed/);
  fails(withHeader({}, (w) => ({ layers: [{ kind: 'points', name: 'p', positions: w.f64([0, 0, 0]) }] })), /has type f64, not f32/);
  fails(withHeader({ layers: [{ kind: 'points', name: 'p', positions: { offset: 4, type: 'f32', count: 0 } }] }), /offset is 4|starts at 4/);
});

test('2000 damaged scenes give a scene or a SceneError, never another fault', () => {
  const rnd = random(42);
  const originals = [roomScene({ points: 200 }), floorScene(), exactScene()];
  let refused = 0;
  for (let i = 0; i < 2000; i++) {
    try {
      parseScene(damaged(originals[i % originals.length], rnd));
    } catch (error) {
      assert.ok(error instanceof SceneError, `damage ${i}: ${String(error)}`);
      assert.ok(error.message.length > 10 && error.message.length < 400 && !error.message.includes('\n'), error.message);
      refused++;
    }
  }
  assert.ok(refused > 800, `only ${refused} of 2000 were refused`);
});

test('base64 and tokens', () => {
  assert.deepEqual([...decodeBase64('AQID')], [1, 2, 3]);
  assert.throws(() => decodeBase64('A*'), SceneError);
  assert.equal(tokenQuery('?token=a%26b&x=1'), '?token=a%26b');
  assert.equal(tokenQuery('?x=1'), '');
});
