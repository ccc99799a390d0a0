// SPDX-License-Identifier: Apache-2.0
// A recording: its frames are fetched as the timeline comes to them, depth is a cloud in the view.
import assert from 'node:assert/strict';
import { afterEach, test } from 'node:test';
import type { Page } from 'playwright-core';
import { readFrameBlock } from '../src/recording/frame_block';
import { SceneError } from '../src/scene/scene';
import { drawn, faultsOf, open, screenshot } from './browser';
import { damaged } from './damage';
import { plainJpeg } from './live_run';
import { until, wait } from './live_testing';
import { near, project, sharedBrowser, useBrowser } from './page_testing';
import { SceneWriter, random } from './scene_writer';
import { serve } from './serve';

useBrowser();

/** What a test leaves open, also one that fails. */
const closing: (() => unknown)[] = [];
afterEach(async () => {
  for (const close of closing.splice(0)) await close();
});

const frames = 20;
/** Moves along x by 0.1 a frame; without a pose from frame 10 on, or at all. */
function scene(posed: number, states?: number[]): Uint8Array {
  const w = new SceneWriter();
  const rows = Array.from({ length: frames }, (_, i) => i);
  return w.finish({
    title: 'corridor', method: 'tum_rgbd', up: [0, -1, 0], scale: { kind: 'metric' }, camera: { width: 640, height: 480, fx: 500, fy: 500, cx: 320, cy: 240 },
    frames: {
      stamps: w.f64(rows.map((i) => 5 + i / 30)), positions: w.f32(rows.flatMap((i) => (i < posed ? [0.1 * i, 0, 0] : [NaN, NaN, NaN]))),
      orientations: w.f32(rows.flatMap((i) => (i < posed ? [0, 0, 0, 1] : [NaN, NaN, NaN, NaN]))),
      ...(states ? { states: w.u8(rows.map((i) => states[i] ?? 0)) } : {}),
    },
    layers: [],
  });
}

/** A red square, two meters ahead of the camera. */
function block(index: number, jpeg: Uint8Array): Uint8Array {
  const w = new SceneWriter();
  const points = Array.from({ length: 900 }, (_, i) => [((i % 30) - 15) / 30, (Math.floor(i / 30) - 15) / 30, 2]).flat();
  return w.finish({ type: 'frame', index, name: `rgb/${index}.png`, width: 640, height: 480, jpeg: w.u8(jpeg), points: w.f32(points), colors: w.u8(points.flatMap((_, i) => (i % 3 ? [] : [255, 0, 0]))) });
}

/** Clouds of recorded frames in the view. */
const cloudsShown = (page: Page) => page.evaluate(() => (window as any).rastro.app.view.marks.children
  .filter((child: any) => child.isPoints && child.visible && child.material.type === 'PointsMaterial').map((child: any) => child.geometry.attributes.position.count));

test('frames are fetched one by one as the timeline comes to them; the newest asked for is shown', async () => {
  const asked: number[] = [];
  let jpeg: Uint8Array = new Uint8Array(0);
  const frame = (index: number) => (asked.push(index), index === 19 ? null : block(index, jpeg));
  const served = await serve([{ name: 'corridor', bytes: scene(10), frame }], 'abc');
  const page = await open(sharedBrowser(), `${served.url}?token=abc`, {});
  closing.push(() => page.close(), () => served.close());
  await page.waitForFunction(() => (window as any).rastro?.ready);
  jpeg = await plainJpeg(page, '#306090');
  const shown = (index: number) => page.waitForFunction((i) => document.querySelector<HTMLElement>('.frame-view')!.dataset.image === `${i}`, index);
  await page.keyboard.press('ArrowRight');
  await shown(1);
  assert.match(await page.locator('.frame-view').innerText(), /Frame 2 of 20.*rgb\/1\.png · 900 points measured/s);
  await page.evaluate(() => {
    for (let i = 2; i <= 9; i++) (window as any).rastro.app.set({ frame: i });
  });
  await shown(9);
  assert.ok(asked.length <= 5, `asked for ${asked}`);
  await page.evaluate(() => {
    const { view } = (window as any).rastro.app;
    view.camera.position.set(0.9, 0, -1);
    view.controls.target.set(0.9, 0, 2);
    view.controls.update();
    view.requestDraw();
  });
  await drawn(page);
  await wait(200);
  const picture = await screenshot(page, 'recording');
  const [x, y] = (await project(page, [1.2, 0.3, 2]))!;
  const around = [-3, -2, -1, 0, 1, 2, 3].flatMap((dx) => [-3, -2, -1, 0, 1, 2, 3].map((dy) => picture.at(Math.round(x + dx), Math.round(y + dy))));
  assert.ok(around.some(([r, g, b]) => r > 200 && g < 60 && b < 60), 'the cloud is where the camera was');
  await page.keyboard.press('End');
  await until(async () => (await page.locator('.frame-view').innerText()).includes('cannot be read'), 'the reason');
  assert.ok(await page.locator('.frame-view .pictures').isHidden(), 'the image of another frame');
  assert.deepEqual(await cloudsShown(page), [], 'the points of another frame');
  assert.deepEqual(faultsOf(page).filter((f) => !/Failed to load resource/.test(f)), []);
});

test('the points of a recording go with its run', async () => {
  const frame = (index: number) => block(index, new Uint8Array(3));
  const served = await serve([{ name: 'corridor', bytes: scene(10), frame }, { name: 'map', bytes: scene(10) }], 'abc');
  const page = await open(sharedBrowser(), `${served.url}?token=abc`, {});
  closing.push(() => page.close(), () => served.close());
  await page.waitForFunction(() => (window as any).rastro?.ready);
  await until(async () => (await cloudsShown(page)).length === 1, 'the points');
  const set = (patch: object) => page.evaluate((p) => (window as any).rastro.app.set(p), patch);
  await set({ hiddenRuns: [0] });
  assert.deepEqual(await cloudsShown(page), []);
  await set({ hiddenRuns: [] });
  assert.deepEqual(await cloudsShown(page), [900]);
  await set({ active: 1 });
  await until(async () => (await cloudsShown(page)).length === 0, 'no points');
  await set({ active: 0 });
  await until(async () => (await cloudsShown(page)).length === 1, 'the points again');
  assert.deepEqual(faultsOf(page), []);
});

test('a recording without poses is seen from its camera', async () => {
  const served = await serve([{ name: 'corridor', bytes: scene(0), frame: (index) => block(index, new Uint8Array(3)) }], 'abc');
  const page = await open(sharedBrowser(), `${served.url}?token=abc`, {});
  closing.push(() => page.close(), () => served.close());
  await page.waitForFunction(() => (window as any).rastro?.ready);
  await until(async () => (await page.locator('.frame-view').innerText()).includes('900 points'), 'the frame');
  await drawn(page);
  await wait(200);
  const picture = await screenshot(page, 'recording_without_poses');
  const [x, y] = (await project(page, [0, 0, 2]))!;
  const seen = [-8, -4, 0, 4, 8].flatMap((dx) => [-8, -4, 0, 4, 8].map((dy) => picture.at(Math.round(x + dx), Math.round(y + dy))[0]));
  assert.ok(Math.max(...seen) > 200, `${seen}`);
  assert.deepEqual(faultsOf(page), []);
});

test('a run of track: features by state with their trails and ids, and the state of the frame', async () => {
  const tracked = (index: number, jpeg: Uint8Array) => {
    const w = new SceneWriter();
    return w.finish({
      type: 'frame', index, name: `${index}.png`, width: 640, height: 480, jpeg: w.u8(jpeg), features: w.f32([320, 240, 100 + index, 100]), feature_states: w.u8([0, 2]),
      feature_state_names: ['matched', 'new', 're_identified'], feature_ids: w.i32([7, 41]), trail_lengths: w.u8([2, 0]), trails: w.f32([200, 240, 320, 240]),
    });
  };
  let jpeg: Uint8Array = new Uint8Array(0);
  const served = await serve([{ name: 'run', bytes: scene(0, [0, 0, 1]), frame: (index) => tracked(index, jpeg) }], 'abc');
  const page = await open(sharedBrowser(), `${served.url}?token=abc`, {});
  closing.push(() => page.close(), () => served.close());
  await page.waitForFunction(() => (window as any).rastro?.ready);
  jpeg = await plainJpeg(page, '#306090');
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('ArrowRight');
  await page.waitForFunction(() => document.querySelector<HTMLElement>('.frame-view')!.dataset.image === '2');
  assert.match(await page.locator('.frame-view').innerText(), /Frame 3 of 20\s*weak.*matched\s*1\s*new\s*0\s*re identified\s*1.*2\.png · 2 features/s);
  const picture = await screenshot(page, 'track_run');
  const box = (await page.locator('.frame-view canvas').first().boundingBox())!;
  const at = (x: number, y: number) => picture.at(Math.round(box.x + (x * box.width) / 640), Math.round(box.y + (y * box.height) / 480));
  // Sky blue along the trail, the image's own blue elsewhere.
  const trail = [-1, 0, 1].map((dy) => picture.at(Math.round(box.x + (260 * box.width) / 640), Math.round(box.y + box.height / 2) + dy));
  assert.ok(trail.some(([r, g, b]) => Math.abs(r - 86) < 40 && Math.abs(g - 180) < 40 && Math.abs(b - 233) < 40), `${trail}`);
  near(at(260, 300), [48, 96, 144], 6);
  await page.locator('.feature-legend button', { hasText: 'matched' }).click();
  await wait(100);
  const hidden = (await screenshot(page, 'track_run_hidden')).at(Math.round(box.x + (260 * box.width) / 640), Math.round(box.y + box.height / 2));
  near(hidden, [48, 96, 144], 6);
  assert.deepEqual(faultsOf(page), []);
});

test('5000 damaged blocks give a frame or a SceneError, never another fault', () => {
  const rnd = random(4);
  const whole = block(3, new Uint8Array(50));
  const counts = { read: 0, refused: 0 };
  for (let i = 0; i < 5000; i++) {
    try {
      readFrameBlock(damaged(whole, rnd));
      counts.read++;
    } catch (error) {
      if (!(error instanceof SceneError)) throw error;
      counts.refused++;
    }
  }
  assert.ok(counts.read > 100 && counts.refused > 100, JSON.stringify(counts));
});
