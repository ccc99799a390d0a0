// SPDX-License-Identifier: Apache-2.0
// Messages of a run, and the record of its frames, without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ImageStore } from '../src/live/image_store';
import { mergedEvents, mergedRows } from '../src/live/merged_rows';
import { readBinary, readText, type LiveFrame, type LiveImage, type LivePlace } from '../src/live/messages';
import { LiveRecord } from '../src/live/record';
import { parseScene } from '../src/scene/parse';
import { SceneError } from '../src/scene/scene';
import { damaged, damagedText } from './damage';
import { allCommands, calibration, featureNames, frame, hello, image, lostFrame, manyFeatures, mapScene, place, status } from './live_run';
import { random } from './scene_writer';

const read = (message: object) => readText(JSON.stringify(message), 5);
const framed = (index: number, options: object = {}) => read(frame(index, options)) as LiveFrame;

test('messages are read as the protocol says', () => {
  const greeting = read(hello({ commands: [...allCommands, 'fly'], frames: null }));
  assert.ok(greeting?.type === 'hello' && greeting.frames === null && greeting.commands.size === allCommands.length);
  const lost = read(lostFrame(7));
  assert.ok(lost?.type === 'frame' && lost.pose === null && lost.sigma === null && lost.reason === 'too_few_matches');
  assert.deepEqual(framed(3).stages[1], ['matching', 3.4]);
  assert.deepEqual(read(status({ mapping: null })), { type: 'status', paused: false, mapping: null, ended: false, line: '', resets: 0 });
  const boards = read(calibration());
  assert.ok(boards?.type === 'calibration' && boards.enoughViews === 20 && boards.cameras[0].missing[6] && !boards.cameras[0].seen[0] && boards.outlines[0].length === 8);
  assert.equal(read({ type: 'weather' }), null);
});

test('what a message lacks is unknown; what is wrong in it is said', () => {
  const short = read({ type: 'frame', index: 0, stamp: 1, state: 0 }) as LiveFrame;
  assert.deepEqual([short.pose, short.ms, short.stages, short.dropped], [null, null, [], 0]);
  const refused = (message: object, pattern: RegExp) => assert.throws(() => read(message), (e) => e instanceof SceneError && pattern.test(e.message));
  refused(frame(-1), /index is -1/);
  refused(frame(0, { state: 5 }), /state is 5/);
  refused(frame(0, { stamp: null }), /stamp is not a number/);
  refused(frame(0, { pose: [1, 2, 3] }), /pose is not a list of 7/);
  refused(frame(0, { events: [{ detail: 'x' }] }), /kind is not a text/);
  refused(hello({ version: 2 }), /version 2/);
  refused([], /not an object/);
  assert.throws(() => readText('{"type":', 5), SceneError);
  assert.throws(() => readText(' '.repeat(2e6), 5), SceneError);
});

test('an image is read with its features; a damaged one is refused', () => {
  const bytes = image(4, { jpeg: new Uint8Array([1, 2, 3]), features: [1, 2, 3, 4], states: [3, 0] });
  const good = readBinary(bytes) as LiveImage;
  assert.deepEqual([good.index, good.width, [...good.features], [...good.states], good.stateNames], [4, 640, [1, 2, 3, 4], [3, 0], featureNames]);
  assert.throws(() => readBinary(image(4, { jpeg: new Uint8Array(3), features: [1, 2], states: [1, 1] })), SceneError);
  assert.throws(() => readBinary(bytes.subarray(0, bytes.length - 20)), SceneError);
  const jpeg = new Uint8Array(3);
  const tracks = readBinary(image(4, { jpeg, features: [1, 2, 3, 4], states: [3, 0], ids: [7, -1], trails: [[0, 2, 1, 2], []] })) as LiveImage;
  assert.deepEqual([[...tracks.ids!], tracks.trails.map((t) => [...t])], [[7, -1], [[0, 2, 1, 2], []]]);
  assert.deepEqual([good.ids, good.trails], [null, []]);
  assert.throws(() => readBinary(image(4, { jpeg, features: [1, 2], states: [3], ids: [7, 8] })), SceneError);
  const seen = readBinary(place(9, 30, { jpeg, features: [1, 2], states: [3], colors: [1, 2, 3] }, { jpeg })) as LivePlace;
  assert.deepEqual([seen.keyframe, seen.image.index, [...seen.image.colors!], seen.matched?.keyframe], [30, 9, [1, 2, 3], 12]);
  const broken = image(4, { jpeg, features: [1, 2], states: [3], trails: [[1, 2, 3, 4, 5, 6]] });
  assert.throws(() => readBinary(Buffer.from(Buffer.from(broken).toString('latin1').replace(/("trails":{"offset":\d+,"type":"f32","count":)6/, '$14'), 'latin1')), /trails has 2 points, not 3/);
  assert.throws(() => readBinary(new Uint8Array(2)), SceneError);
});

test('20000 damaged messages give a message or a SceneError, never another fault', () => {
  const rnd = random(8);
  const texts = [hello(), status(), frame(3), lostFrame(4), { type: 'scene', index: 0, revision: 3 }, calibration()].map((m) => JSON.stringify(m));
  const jpeg = new Uint8Array(100);
  const tracked = { jpeg, ...manyFeatures(20, 1), ids: [...Array(20).keys()], trails: Array.from({ length: 20 }, () => [1, 2, 3, 4]) };
  const blocks = [image(4, { jpeg, ...manyFeatures(20, 1) }), image(4, tracked), place(4, 7, tracked, { jpeg })];
  const counts = { read: 0, refused: 0 };
  const record = new LiveRecord();
  for (let i = 0; i < 20000; i++) {
    try {
      const message = i % 4 === 3 ? readBinary(damaged(blocks[(i >> 2) % 3], rnd)) : readText(damagedText(texts[i % texts.length], rnd), 5);
      if (message?.type === 'frame') record.append(message);
      counts.read++;
    } catch (error) {
      assert.ok(error instanceof SceneError && !error.message.includes('\n') && error.message.length < 400, String(error));
      counts.refused++;
    }
  }
  assert.ok(counts.read > 2000 && counts.refused > 4000, JSON.stringify(counts));
});

test('the record grows, and refuses what it knows', () => {
  const record = new LiveRecord();
  for (let i = 0; i < 1000; i++) assert.ok(record.append(framed(i, i % 100 === 50 ? { pose: null, state: 2 } : {})));
  assert.ok(!record.append(framed(999)));
  assert.ok(!record.append(framed(1000, { stamp: 5 })));
  const frames = record.frames!;
  assert.equal(frames.count, 1000);
  assert.ok(Number.isNaN(frames.positions[3 * 50]) && frames.states![50] === 2);
  assert.ok(Math.abs(frames.stamps[999] - (100 + 999 / 30)) < 1e-9);
  assert.equal(record.events.filter((e) => e.kind === 'lost').length, 10);
});

test('a map brings better poses and the frames that were missed', () => {
  const record = new LiveRecord();
  for (const i of [5, 6, 8, 50]) record.append(framed(i));
  const scene = parseScene(mapScene(1, 2, 0.5)); // frames 0 to 10
  record.merge(scene.frames!, scene.stateNames);
  const frames = record.frames!;
  assert.equal(frames.count, 12);
  assert.deepEqual([...frames.stamps], [...frames.stamps].sort((a, b) => a - b));
  assert.ok(Math.abs(frames.positions[3 * 5] - frames.online![3 * 5] - 0.5) < 1e-5);
  assert.ok(Number.isNaN(frames.online![3 * 7]) && frames.positions[3 * 11] === frames.online![3 * 11]);
  assert.deepEqual(record.details.map((d) => d?.index ?? -1), [-1, -1, -1, -1, -1, 5, 6, -1, 8, -1, -1, 50]);
  assert.ok(record.append(framed(51)));
  assert.equal(record.frames!.count, 13);
});

test('stamps and events of two lists', () => {
  assert.deepEqual(mergedRows(Float64Array.of(1, 3), Float64Array.of(1, 2)), [{ own: 0, other: 0 }, { own: -1, other: 1 }, { own: 1, other: -1 }]);
  const event = (stamp: number, kind: string) => ({ frame: 3, stamp, kind, detail: '' });
  assert.deepEqual(mergedEvents([event(2, 'lost')], [event(1, 'loop_closed'), event(2, 'lost')]).map((e) => e.kind), ['loop_closed', 'lost']);
});

test('images are kept up to a size, and found by the nearest frame before', () => {
  const store = new ImageStore();
  for (let i = 0; i < 100; i += 3) store.add(readBinary(image(i, { jpeg: new Uint8Array(2e6) })) as LiveImage);
  assert.ok(!store.add(readBinary(image(3, { jpeg: new Uint8Array(1) })) as LiveImage));
  assert.equal(store.near(98)!.index, 96);
  assert.equal(store.near(150), null);
  assert.equal(store.last!.index, 99);
});
