// SPDX-License-Identifier: Apache-2.0
// The built page on a run that goes on: frames, image and features, maps, controls, a lost connection.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Page } from 'playwright-core';
import { drawn, screenshot } from './browser';
import { corridorJpeg, frame, hello, image, lostFrame, manyFeatures, mapScene, place, plainJpeg, status } from './live_run';
import { runState, shownFrame, shownImage, until, wait, withRun } from './live_testing';
import { clickPoint, near, pixelAt, project, useBrowser } from './page_testing';

useBrowser();

const view = (page: Page) => page.evaluate(() => {
  const { camera, controls } = (window as any).rastro.app.view;
  return [...camera.position.toArray(), ...controls.target.toArray()] as number[];
});
const state = (page: Page) => page.evaluate(() => {
  const { app, live } = (window as any).rastro;
  return { frame: app.state.frame as number, count: live.record.count as number, following: live.following as boolean };
});

test('the trajectory grows and is drawn as the frames come, in the colors of their states', () => withRun({}, async (page, server) => {
  await runState(page, 'waiting for the first frame');
  for (let i = 0; i < 60; i++) server.send(frame(i, i >= 30 && i < 45 ? { state: 1 } : {}));
  await shownFrame(page, 59);
  await runState(page, 'running');
  // The content follows the frames about once a second: one that was measured before the last of them is fitted to a part.
  await page.locator('[data-layer="trajectory:final"] .detail', { hasText: /^60 frames$/ }).waitFor();
  await page.evaluate(() => (window as any).rastro.app.fit());
  await drawn(page);
  const at = (i: number) => (frame(i).pose as number[]).slice(0, 3);
  near(await pixelAt(page, at(15), 'live_grown'), [0x00, 0x9e, 0x73], 8);
  near(await pixelAt(page, at(38), 'live_grown'), [0xe6, 0x9f, 0x00], 8);
  near(await pixelAt(page, at(59), 'live_grown'), [0xf0, 0xe4, 0x42], 6);
  const before = await pixelAt(page, at(75), 'live_grown');
  for (let i = 60; i < 80; i++) server.send(frame(i));
  await shownFrame(page, 79);
  await page.locator('[data-layer="trajectory:final"] .detail', { hasText: /^80 frames$/ }).waitFor();
  await page.evaluate(() => (window as any).rastro.app.fit());
  await drawn(page);
  near(await pixelAt(page, at(75), 'live_grown2'), [0x00, 0x9e, 0x73], 8);
  assert.notDeepEqual(before, [0x00, 0x9e, 0x73]);
  assert.match(await page.locator('.clock').innerText(), /2\.63 s/);
  assert.match(await page.locator('.run-facts').innerText(), /80 of 240 frames · 43\.1 \/ s · 131 MB/);
}));

test('nobody touches the view: the newest pose stays in sight', () => withRun({}, async (page, server) => {
  for (let i = 0; i < 100; i += 4) {
    server.send(frame(i, { pose: [i, 0, 0, 0, 0, 0, 1] }));
    await wait(60);
  }
  await shownFrame(page, 96);
  await until(async () => {
    server.send(frame((await state(page)).count * 4 + 100, { pose: [96, 0, 0, 0, 0, 0, 1] }));
    const p = await project(page, [96, 0, 0]);
    return p !== null && p[0] > 276 && p[0] < 1280 && p[1] > 44 && p[1] < 660;
  }, 'the pose in sight');
}));

test('features are drawn at their pixels, by color and shape, with counts', () => withRun({}, async (page, server) => {
  const jpeg = await plainJpeg(page, '#202020');
  const features = [100, 100, 320, 240, 600, 440, 100, 400, 500, 100, 501, 101];
  server.send(frame(0));
  server.sendBytes(image(0, { jpeg, features, states: [3, 2, 1, 4, 0, 0] }));
  await shownImage(page, 0);
  await wait(100);
  const picture = await screenshot(page, 'live_features');
  const box = (await page.locator('.frame-view > .pictures canvas').boundingBox())!;
  assert.ok(Math.abs(box.width / box.height - 4 / 3) < 0.02);
  const at = (x: number, y: number, dx = 0, dy = 0) => picture.at(Math.round(box.x + (x * box.width) / 640 + dx), Math.round(box.y + (y * box.height) / 480 + dy));
  near(at(100, 100), [0x00, 0x9e, 0x73], 12);
  near(at(320, 240), [0xd5, 0x5e, 0x00], 60);
  near(at(200, 200), [0x20, 0x20, 0x20], 6);
  const legend = await page.locator('.feature-legend button').allInnerTexts();
  assert.deepEqual(legend.map((t) => t.replace(/\s+/g, ' ')), ['unmatched 2', 'matched 1', 'outlier 1', 'inlier 1', 'new 1']);
  await page.locator('.feature-legend button', { hasText: 'inlier' }).click();
  await page.mouse.move(600, 300);
  const without = await screenshot(page, 'live_features_hidden');
  near(without.at(Math.round(box.x + (100 * box.width) / 640), Math.round(box.y + (100 * box.height) / 480)), [0x20, 0x20, 0x20], 6);
}));

const wordNames = ['known_word', 'new_word', 'repeated_word', 'previous_word', 'shared_word'];
const words = (count: number) => ({ ...manyFeatures(count, 3), names: wordNames });

test('a keyframe is shown with its words, and the place it was matched with; pixels of depth in their colors', () => withRun({}, async (page, server) => {
  const [jpeg, other] = [await plainJpeg(page, '#202020'), await plainJpeg(page, '#806040')];
  server.send(frame(0));
  server.sendBytes(image(0, { jpeg }));
  server.sendBytes(place(0, 30, { jpeg, features: [100, 100], states: [4], names: wordNames }, { jpeg: other, features: [320, 240], states: [4], names: wordNames }));
  await page.locator('.place .matched canvas').waitFor({ state: 'visible' });
  await wait(200);
  const at = async (name: string, selector: string, x: number, y: number) => {
    const box = (await page.locator(selector).boundingBox())!;
    return (await screenshot(page, name)).at(Math.round(box.x + (x * box.width) / 640), Math.round(box.y + (y * box.height) / 480));
  };
  near(await at('live_place', '.place .matched canvas', 100, 400), [0x80, 0x60, 0x40], 8);
  assert.match(await page.locator('.place').innerText(), /keyframe 30, frame 1\s+matched place: keyframe 12/);
  assert.match((await page.locator('.place .feature-legend').innerText()).replace(/\s+/g, ' '), /shared word 1/);
  server.sendBytes(place(4, 31, { jpeg, features: [320, 240, 100, 100], states: [0, 0], names: ['depth'], colors: [0, 0, 255, 255, 0, 0] }));
  await page.locator('.place', { hasText: 'keyframe 31' }).waitFor();
  await wait(200);
  assert.ok(await page.locator('.place .matched').isHidden());
  near(await at('live_depths', '.place figure canvas >> nth=0', 320, 240), [0, 0, 255], 30);
}));

test('tracks have trails, and their ids under the pointer or where they are few; a run without poses is all image', () => withRun({}, async (page, server) => {
  const jpeg = await plainJpeg(page, '#202020');
  const many = manyFeatures(60, 2);
  const ids = many.states.map((_, i) => 1000 + i);
  many.features.splice(0, 2, 320, 240);
  server.send(frame(0, { pose: null }));
  server.sendBytes(image(0, { jpeg, ...many, states: many.states.map(() => 3), ids, trails: ids.map((_, i) => (i === 0 ? [120, 240, 220, 240, 320, 240] : [])) }));
  await shownImage(page, 0);
  await wait(100);
  const box = (await page.locator('.frame-view > .pictures canvas').boundingBox())!;
  assert.ok(box.width > 600, `${box.width} px`);
  const place = (x: number, y: number) => [Math.round(box.x + (x * box.width) / 640), Math.round(box.y + (y * box.height) / 480)];
  const [x, y] = place(200, 240);
  const bare = await screenshot(page, 'live_trails');
  const green = [-1, 0, 1].map((d) => bare.at(x, y + d)[1]);
  assert.ok(Math.max(...green) > 120, `${green}`);
  await page.mouse.move(...(place(322, 242) as [number, number]));
  const named = await screenshot(page, 'live_trails_id');
  const [labelX, labelY] = place(320, 240);
  assert.ok(named.at(labelX + 9, labelY - 6)[0] < 8 && bare.at(labelX + 9, labelY - 6)[0] > 20, 'the id under the pointer');
  assert.ok(!(await page.locator('.facts-line').innerText()).includes('no pose'));
}, (server) => {
  server.greeting = [hello({ poses: false }), status()];
}));

test('stage times are bars; a loss says why and what to do', () => withRun({}, async (page, server) => {
  server.send(frame(0));
  await shownFrame(page, 0);
  assert.ok(await page.locator('.trouble').isHidden());
  assert.match(await page.locator('.stages').innerText(), /features\s+6\.1 ms\s+matching\s+3\.4 ms/);
  const widths = await page.locator('.stages .fill').evaluateAll((bars) => bars.map((b) => b.getBoundingClientRect().width));
  assert.ok(Math.abs(widths[0] / widths[5] - 6.1 / 14.2) < 0.03, `${widths}`);
  server.send(lostFrame(1));
  await shownFrame(page, 1);
  const text = await page.locator('.trouble').innerText();
  assert.match(text, /Tracking lost: too few matches/);
  assert.match(text, /7 matches with the map, at least 20 needed/);
  assert.match(text, /Point the camera back/);
  assert.match(await page.locator('.facts-line').innerText(), /7 tracked.*no pose/s);
}));

test('a new map replaces the layers: the view, switches, colors and the frame stay; never two fetches at once', () => withRun({}, async (page, server) => {
  for (let i = 0; i <= 60; i++) server.send(frame(i));
  await shownFrame(page, 60);
  server.scene = mapScene(1, 5);
  server.send({ type: 'scene', index: 0, revision: 1 });
  await page.locator('[data-layer="points:landmarks"]').waitFor();
  assert.match(await page.locator('.facts').innerText(), /revision 1/);
  await page.locator('[data-layer="edges:covisibility"] input').click();
  await page.evaluate(() => (window as any).rastro.app.set({ pointColor: 'age', trajectoryColor: 'time' }));
  await page.keyboard.press('Shift+ArrowLeft');
  const before = await view(page);
  const switched = await page.locator('[data-layer="edges:covisibility"] input').isChecked();
  server.sceneDelayMs = 80;
  server.scene = mapScene(9, 6, 0.4);
  for (let revision = 2; revision < 10; revision++) {
    server.send({ type: 'scene', index: 0, revision });
    await wait(25);
  }
  await page.locator('.facts', { hasText: 'revision 9' }).waitFor();
  assert.equal(server.mostFetching, 1);
  assert.ok(server.fetches < 9, `${server.fetches} fetches`);
  near(await view(page), before, 1e-9);
  assert.equal(await page.locator('[data-layer="edges:covisibility"] input').isChecked(), switched);
  assert.match(await page.locator('[data-layer="points:landmarks"]').innerText(), /600 points/);
  const kept = await page.evaluate(() => {
    const { app } = (window as any).rastro;
    return [app.state.pointColor, app.state.trajectoryColor, app.state.frame, app.frames.positions[0], app.frames.online[0], app.view.points.length];
  });
  assert.deepEqual(kept.slice(0, 3), ['age', 'time', 50]);
  near(kept.slice(3) as number[], [0.4, 0, 1], 1e-5);
  await screenshot(page, 'live_scene');
}));

test('a map that cannot be read leaves the one before, with one line', () => withRun({}, async (page, server) => {
  server.scene = mapScene(2, 4).subarray(0, 3000);
  server.send({ type: 'scene', index: 0, revision: 2 });
  await page.locator('.run-fault', { hasText: '1 unreadable' }).waitFor();
  assert.match((await page.locator('.run-fault').getAttribute('title'))!, /the map: .*cut off/);
  assert.match(await page.locator('.facts').innerText(), /revision 1/);
}, (server) => {
  server.scene = mapScene(1, 4);
}));

test('a page opened in the middle has the frames before it from the map', () => withRun({}, async (page, server) => {
  for (let i = 45; i < 50; i++) server.send(frame(i));
  await shownFrame(page, 49);
  assert.equal((await state(page)).count, 46); // 0 to 40 of the map, 45 to 49 told
  assert.equal(await page.locator('h1').innerText(), 'corridor');
}, (server) => {
  server.scene = mapScene(1, 5);
}));

test('scrubbing back stops following; Live returns', () => withRun({}, async (page, server) => {
  const jpeg = await plainJpeg(page, '#404040');
  for (let i = 0; i < 40; i++) {
    server.send(frame(i));
    if (i % 4 === 0) server.sendBytes(image(i, { jpeg }));
  }
  await shownFrame(page, 39);
  await page.keyboard.press('Shift+ArrowLeft');
  await page.keyboard.press('Shift+ArrowLeft');
  await shownFrame(page, 19);
  await shownImage(page, 16);
  assert.equal(await page.locator('.live').getAttribute('aria-pressed'), 'false');
  server.send(frame(40));
  await until(async () => (await state(page)).count === 41, 'the frame');
  assert.deepEqual(await state(page), { frame: 19, count: 41, following: false });
  await page.locator('.live').click();
  await shownFrame(page, 40);
  server.send(frame(41));
  await shownFrame(page, 41);
  await page.keyboard.press('ArrowLeft');
  await page.keyboard.press('End');
  server.send(frame(42));
  await shownFrame(page, 42);
}));

test('controls send what they say and show only what the run says', () => withRun({}, async (page, server) => {
  const last = () => server.commands.map((c) => (JSON.parse(c) as { command: string }).command).join(' ');
  const pause = page.locator('.run-buttons button').first();
  assert.ok(await page.getByRole('button', { name: 'Step' }).isDisabled());
  await pause.click();
  await until(() => last() === 'pause', 'pause');
  assert.equal(await pause.getAttribute('aria-label'), 'Pause'); // not said yet
  assert.equal(await pause.getAttribute('aria-busy'), 'true');
  server.send(status({ paused: true, line: 'after frame 12' }));
  await runState(page, 'paused: after frame 12');
  assert.equal(await pause.getAttribute('aria-label'), 'Resume');
  await page.keyboard.press('n');
  await page.keyboard.press('o');
  await until(() => last() === 'pause step mapping_off', 'step and localization only');
  server.send(status({ paused: true, mapping: false }));
  await page.getByRole('button', { name: 'Resume mapping' }).click();
  await page.keyboard.press('p');
  await page.keyboard.press('w');
  await until(() => last() === 'pause step mapping_off mapping_on resume save', 'mapping, resume, save');
  await page.keyboard.press('r');
  await page.getByRole('dialog').getByRole('button', { name: 'Cancel' }).click();
  await page.keyboard.press('e');
  await screenshot(page, 'live_ask');
  await page.getByRole('dialog').getByRole('button', { name: 'End the run' }).click();
  await until(() => last().endsWith('save end'), 'end, and no reset');
  await page.getByRole('button', { name: 'Reset' }).click();
  await page.getByRole('dialog').getByRole('button', { name: 'Reset' }).click();
  await until(() => last().endsWith('end reset'), 'reset');
  server.send(status({ ended: true, line: 'results written' }));
  await runState(page, 'run ended: results written');
  for (const node of await page.locator('.run-buttons button').all()) assert.ok(await node.isDisabled());
}));

test('after a reset the page shows the frames of the new map alone', () => withRun({}, async (page, server) => {
  for (let i = 0; i < 60; i++) server.send(frame(i));
  await shownFrame(page, 59);
  server.send(status({ resets: 1, line: 'a new map begins; the one before is saved' }));
  await wait(1100); // so that the view may be fitted anew
  for (let i = 60; i < 63; i++) server.send(frame(i, { pose: [40, 0, 0, 0, 0, 0, 1] }));
  await shownFrame(page, 62);
  assert.equal((await state(page)).count, 3);
  await runState(page, 'the one before is saved');
  server.scene = mapScene(2, 2, 0, { frames: undefined });
  server.send({ type: 'scene', index: 0, revision: 2 });
  await page.locator('.facts', { hasText: 'revision 2' }).waitFor();
  assert.equal((await state(page)).count, 3);
}, (server) => {
  server.scene = mapScene(1, 5);
}));

test('after a reset neither the map, nor its scale, nor what was measured in it comes back', () => withRun({}, async (page, server) => {
  for (let i = 50; i < 60; i++) server.send(frame(i));
  await shownFrame(page, 59);
  await page.locator('[data-layer="points:landmarks"]').waitFor();
  await page.evaluate(() => (window as any).rastro.app.fit());
  await drawn(page);
  await page.keyboard.press('m');
  for (const row of [0, 250]) {
    await clickPoint(page, await page.evaluate((r) => {
      const { positions } = (window as any).rastro.app.runs[0].scene.layers.find((l: any) => l.kind === 'points');
      return [...positions.subarray(3 * r, 3 * r + 3)] as number[];
    }, row));
  }
  await page.getByLabel('Known length in meters').fill('3');
  await page.keyboard.press('Enter');
  assert.match(await page.locator('.lengths .value').innerText(), /3 m \(known\)/);
  server.sceneDelayMs = 300;
  server.send({ type: 'scene', index: 0, revision: 2 }); // the old map is on its way
  await until(() => server.fetches >= 2, 'the fetch');
  server.send(status({ resets: 1, line: 'a new map begins' }));
  await runState(page, 'a new map begins');
  await wait(500);
  assert.equal((await state(page)).count, 0);
  assert.equal(await page.locator('[data-layer="points:landmarks"]').count(), 0);
  assert.match(await page.locator('.facts').innerText(), /no map yet/);
  assert.equal(await page.evaluate(() => (window as any).rastro.app.scaleFactors.size), 0);
  assert.equal(await page.locator('.lengths .value').count(), 0);
  for (let i = 60; i < 63; i++) server.send(frame(i));
  server.scene = mapScene(1, 2, 0, { frames: undefined });
  server.send({ type: 'scene', index: 0, revision: 1 });
  await page.locator('[data-layer="points:landmarks"]').waitFor();
  assert.equal((await state(page)).count, 3);
}, (server) => {
  server.greeting = [hello(), status({ resets: 0 })];
  server.scene = mapScene(1, 5);
}));

test('only commands that the run understands have buttons', () => withRun({}, async (page) => {
  await page.locator('.run-buttons button:visible').first().waitFor();
  assert.deepEqual(await page.locator('.run-buttons button:visible').evaluateAll((b) => b.map((n) => n.getAttribute('aria-label'))), ['Pause', 'End']);
}, (server) => {
  server.greeting = [hello({ commands: ['pause', 'resume', 'end', 'fly'] }), status({ mapping: null })];
}));

test('a lost connection is tried again; what is shown stays; the end of the program is said', () => withRun({}, async (page, server) => {
  for (let i = 0; i < 10; i++) server.send(frame(i));
  await shownFrame(page, 9);
  await server.close();
  await runState(page, 'connection lost, trying again');
  assert.ok(await page.locator('.run-buttons button').first().isDisabled());
  server.scene = mapScene(3, 3);
  await server.open();
  await runState(page, 'running');
  await page.locator('.facts', { hasText: 'revision 3' }).waitFor();
  server.send(frame(30));
  await shownFrame(page, 30);
  assert.equal((await state(page)).count, 22);
  server.send(status({ ended: true }));
  await runState(page, 'run ended');
  await server.close();
  await runState(page, "the run's program has ended");
  assert.equal((await state(page)).count, 22);
  await server.open();
  await page.getByRole('button', { name: 'Try again' }).click();
  await runState(page, 'running');
  server.send(frame(2)); // another run at the same address
  await shownFrame(page, 2);
  assert.equal((await state(page)).count, 1);
}));

for (const [name, options] of Object.entries({ dark: { dark: true }, light: { dark: false }, narrow: { width: 390, height: 844 }, narrow_light: { width: 390, height: 844, dark: false } })) {
  test(`a whole run, ${name}`, () => withRun(options, async (page, server) => {
    const [jpeg, matched] = [await corridorJpeg(page, 640, 480), await corridorJpeg(page, 320, 240, 2)];
    for (let i = 0; i < 140; i++) server.send(i > 70 && i < 84 ? frame(i, { state: 1 }) : i === 120 ? frame(i, { events: [{ kind: 'loop_closed', detail: 'keyframes 12 and 2' }] }) : frame(i));
    server.scene = mapScene(12, 14);
    server.send({ type: 'scene', index: 0, revision: 12 });
    server.sendBytes(image(139, { jpeg, ...manyFeatures(500, 4) }));
    server.sendBytes(place(138, 14, { jpeg, ...words(300) }, { jpeg: matched, ...words(250) }));
    await shownFrame(page, 139);
    await page.locator('.facts', { hasText: 'revision 12' }).waitFor({ state: 'attached' });
    if ((options as { width?: number }).width) {
      assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
      for (const node of await page.locator('.run-buttons button:visible').all()) assert.ok((await node.boundingBox())!.width >= 28);
      await screenshot(page, `live_${name}_closed`);
      await page.locator('.frame-view summary').click();
    }
    await shownImage(page, 139);
    await page.evaluate(() => (window as any).rastro.app.fit());
    await drawn(page);
    await wait(300);
    await screenshot(page, `live_${name}`);
    const box = (await page.locator('.frame-view').boundingBox())!;
    const room = (await page.locator('.view').boundingBox())!;
    assert.ok(box.x >= 0 && box.x + box.width <= page.viewportSize()!.width && box.y >= room.y && box.y + box.height <= room.y + room.height);
    assert.ok((options as { width?: number }).width || box.x >= room.x + room.width - 1, 'the frame view hides the map');
    for (let i = 140; i < 146; i++) server.send(lostFrame(i));
    await shownFrame(page, 145);
    await wait(300);
    await screenshot(page, `live_${name}_lost`);
    await page.locator('.frame-view summary').click();
    assert.ok((await page.locator('.frame-view').boundingBox())!.height < 60);
  }));
}
