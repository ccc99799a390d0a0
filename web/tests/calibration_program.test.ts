// SPDX-License-Identifier: Apache-2.0
// A calibration of the program, from a replay of recorded chessboards: what it tells is on the page, and the page ends
// it. Only where RASTRO_PROGRAM names the program and RASTRO_DATA the recordings.
import assert from 'node:assert/strict';
import { copyFileSync, existsSync, mkdirSync, readdirSync } from 'node:fs';
import { before, test } from 'node:test';
import { faultsOf, open, screenshot } from './browser';
import { runState, until } from './live_testing';
import { sharedBrowser, useBrowser } from './page_testing';
import { scratchFolder, serving, skip as noProgram } from './program_testing';

const boards = `${process.env.RASTRO_DATA ?? ''}/chessboards`;
const skip = noProgram || !existsSync(boards);
const folder = scratchFolder('calibrate');
useBrowser();
before(() => {
  if (skip) return;
  mkdirSync(`${folder}/left`);
  // Each board is held still for three images.
  const images = readdirSync(boards).filter((name) => /^left\d+\.jpg$/.test(name)).sort();
  for (const name of images) for (const k of [1, 2, 3]) copyFileSync(`${boards}/${name}`, `${folder}/left/${name.replace('.jpg', `_${k}.jpg`)}`);
});

test('the program is asked to calibrate from what it has', { skip, timeout: 120_000 }, async () => {
  const { url, child } = await serving(folder, 'calibrate', 'replay:left', '--rate', '4', '--board', 'chessboard:9x6:0.025', '--out', 'camera', '--view');
  const ended = new Promise((done) => child.once('exit', done));
  const page = await open(sharedBrowser(), url, {});
  try {
    await page.locator('.calibration .next').waitFor({ timeout: 60_000 });
    const views = () => page.evaluate(() => ((window as any).rastro.live.calibration?.views ?? 0) as number);
    await until(async () => (await views()) >= 6, 'six views', 60_000);
    await page.waitForFunction(() => document.querySelector<HTMLElement>('.frame-view')!.dataset.image);
    const told = await page.evaluate(() => {
      const { calibration, images } = (window as any).rastro.live;
      return { outlines: calibration.outlines.length as number, views: calibration.views as number, seen: calibration.cameras[0].seen.filter((s: boolean) => s).length as number, corners: images.last.features.length / 2 as number };
    });
    assert.equal(told.outlines, told.views);
    assert.ok(told.seen > 12, `${told.seen} of 36 cells`);
    assert.ok(told.corners === 54 || told.corners === 0, `${told.corners} corners`);
    await screenshot(page, 'calibration_program');
    await page.getByRole('button', { name: 'Calibrate now' }).click();
    await page.getByRole('button', { name: 'Calibrate', exact: true }).click();
    await runState(page, /run ended: calibrated from \d+ views/);
    assert.deepEqual(faultsOf(page).filter((fault) => !/404/.test(fault)), [], 'but for the map that it never has');
  } finally {
    await page.close();
  }
  assert.equal(await ended, 0);
  assert.ok(existsSync(`${folder}/camera/camera.yaml`));
});
