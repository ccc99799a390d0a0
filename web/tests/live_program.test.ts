// SPDX-License-Identifier: Apache-2.0
// A run of the program that goes on: how soon a frame is on the page after it was processed. Each frame is asked for from
// the page, so that the time is known from one clock. Only where RASTRO_PROGRAM names the program.
import assert from 'node:assert/strict';
import { before, test } from 'node:test';
import { faultsOf, open } from './browser';
import { median } from './live_testing';
import { sharedBrowser, useBrowser } from './page_testing';
import { rastro, scratchFolder, serving, skip } from './program_testing';

const limitMs = Number(process.env.RASTRO_WEB_LIVE_LIMIT_MS ?? 100);
const folder = scratchFolder('live');
useBrowser();
before(() => {
  if (skip) return;
  rastro(folder, 'simulate', 'study', '--out', 'study', '--frames', '200', '--every', '2', '--quiet');
});

/** From the command for a frame to the picture that shows it, without the time that the program says it took. */
async function stepped(): Promise<{ frame: number; ms: number }[]> {
  const { live } = (window as any).rastro;
  const shownView = document.querySelector<HTMLElement>('.frame-view')!;
  const times: { frame: number; ms: number }[] = [];
  for (let k = 0; k < 60; k++) {
    const before = live.record.lastIndex as number;
    const asked = performance.now();
    live.send('step');
    while (!(Number(shownView.dataset.frame) > before)) await new Promise((done) => requestAnimationFrame(done));
    times.push({ frame: before + 1, ms: performance.now() - asked - live.newest.ms });
  }
  return times;
}

for (const method of ['rgbd', 'orb']) {
  test(`a frame of ${method} is on the page within ${limitMs} ms after it was processed`, { skip, timeout: 120_000 }, async (t) => {
    const { url, child } = await serving(folder, 'slam', 'replay:study', '--speed', '4', '--loop', '--method', method, '--out', `run_${method}`, '--view');
    const page = await open(sharedBrowser(), url, {});
    try {
      await page.waitForFunction(() => (window as any).rastro.live?.hello);
      await page.evaluate(() => (window as any).rastro.live.send('pause'));
      await page.waitForFunction(() => (window as any).rastro.live.status?.paused);
      const times = (await page.evaluate(stepped)).map((each) => each.ms);
      t.diagnostic(`${median(times).toFixed(0)} ms (median), at most ${Math.max(...times).toFixed(0)} ms, of ${times.length} frames`);
      assert.ok(median(times) <= limitMs, `${median(times)} ms`);
      assert.deepEqual(faultsOf(page).filter((fault) => !/404/.test(fault)), [], 'but for the map that is not there yet');
    } finally {
      await page.close();
      child.kill();
    }
  });
}
