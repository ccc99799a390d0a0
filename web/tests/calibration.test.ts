// SPDX-License-Identifier: Apache-2.0
// The assistant of a calibration on the built page: where to hold the board, what is covered, when it is enough.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Page } from 'playwright-core';
import { screenshot } from './browser';
import { calibration, corridorJpeg, coverage, frame, hello, image, status } from './live_run';
import { runState, shownImage, until, withRun } from './live_testing';
import { useBrowser } from './page_testing';

useBrowser();

const states = ['no_board', 'moving', 'nothing_new', 'one_camera', 'taken'];
const greeting = [hello({ title: 'camera', method: 'calibrate', state_names: states, frames: null, poses: false, commands: ['pause', 'resume', 'step', 'end'] }), status()];

async function showBoard(page: Page, server: { send: (m: object) => void; sendBytes: (b: Uint8Array) => void }): Promise<void> {
  server.send(frame(0, { state: 4, pose: null, sigma: null, score: null, events: [{ kind: 'view_taken', detail: 'view 7' }] }));
  const corners = Array.from({ length: 54 }, (_, k) => [330 + 16 * (k % 9), 120 + 18 * Math.floor(k / 9)]).flat();
  server.sendBytes(image(0, { jpeg: await corridorJpeg(page, 640, 480), features: corners, states: Array(54).fill(1), names: ['corner', 'taken'] }));
  server.send(calibration());
  await shownImage(page, 0);
  await page.locator('.calibration .next', { hasText: 'lower left' }).waitFor();
}

for (const size of [{ width: 1280, height: 800 }, { width: 390, height: 844 }]) {
  test(`the page says where to hold the board, ${size.width} pixels wide`, () => withRun(size, async (page, server) => {
    await showBoard(page, server);
    const shown = page.locator('.calibration');
    assert.match(await shown.innerText(), /views taken\s+7 of 20/);
    assert.match(await shown.innerText(), /tilt left or right\s+23° of 15°/);
    assert.match(await shown.innerText(), /tilt up or down\s+8° of 15°/);
    assert.deepEqual(await page.locator('.lacking li').allInnerTexts(), ['lower left', 'upper left', 'boards tilted up or down']);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), 'nothing sticks out');
    const box = (await page.locator('.frame-view figure canvas').first().boundingBox())!;
    assert.ok(box.y + box.height <= size.height && box.width > 0.25 * size.width, JSON.stringify(box));
    assert.ok(Math.abs(box.width / box.height - 4 / 3) < 0.02);
    const next = (await page.locator('.calibration .next').boundingBox())!;
    assert.ok(next.y + next.height <= size.height, 'the instruction is seen without scrolling');
    const picture = await screenshot(page, `calibration_${size.width}`);
    const at = (x: number, y: number) => picture.at(Math.round(box.x + (x * box.width) / 640), Math.round(box.y + (y * box.height) / 480));
    const [r, , b] = at(30, 400);
    const [r2, , b2] = at(30, 240);
    assert.ok(r - b > r2 - b2 + 15, `where the board is wanted the image is orange: ${at(30, 400)} and ${at(30, 240)}`);
    const [red, green] = at(610, 240);
    assert.ok(green > red + 8, `what is covered is green: ${at(610, 240)}`);
  }, (server) => (server.greeting = greeting)));
}

test('a page that is opened without a further image shows what is missing', () => withRun({}, async (page) => {
  await page.locator('.calibration .next', { hasText: 'lower left' }).waitFor();
  assert.equal(await page.locator('.pictures figure').first().isVisible(), false);
}, (server) => (server.greeting = [...greeting, calibration()])));

test('of a pair each camera has its own', () => withRun({}, async (page, server) => {
  server.send(frame(0, { state: 0, pose: null }));
  server.sendBytes(image(0, { jpeg: await corridorJpeg(page, 640, 480), width: 1280 }));
  server.send(calibration({ cameras: [coverage({ name: 'left' }), coverage({ name: 'right', tilts: [16, 0, 17, 0] })], line: 'hold it still' }));
  await shownImage(page, 0);
  await page.locator('.calibration .next', { hasText: 'hold it still' }).waitFor();
  assert.match(await page.locator('.calibration').innerText(), /right: tilt up or down\s+17° of 15°/);
  await screenshot(page, 'calibration_pair');
}, (server) => (server.greeting = greeting)));

test('it says when it is enough, and calibrates at once when asked', () => withRun({}, async (page, server) => {
  await showBoard(page, server);
  await page.getByRole('button', { name: 'Calibrate now' }).click();
  await page.getByRole('button', { name: 'Calibrate', exact: true }).click();
  await until(() => server.commands.includes('{"command":"end"}'), 'the command');
  server.send(calibration({ enough: true, missing: [], views: 21, line: 'enough: the camera is calibrated from these views', cameras: [coverage({ missing: Array(9).fill(0) })] }));
  server.send(status({ ended: true, line: 'calibrated from 21 views: good' }));
  await page.locator('.calibration.enough .lacking .none').waitFor();
  await runState(page, /calibrated from 21 views: good/);
}, (server) => (server.greeting = greeting)));

test('a message of a calibration that cannot be read is named', () => withRun({}, async (page, server) => {
  const bad = [calibration({ cameras: [coverage({ seen: [1, 0, 1] })] }), calibration({ outlines: [['x']] }), calibration({ views: -1 }), calibration({ wanted_tilt: 0 }), calibration({ missing: 'all' })];
  for (const message of bad) server.send(message);
  await page.locator('.run-fault', { hasText: `${bad.length} unreadable` }).waitFor();
}, (server) => (server.greeting = greeting)));
