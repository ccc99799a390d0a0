// SPDX-License-Identifier: Apache-2.0
// The shelf of a map that the program made, measured in the page by two clicks on points and on edges, with a person's
// error of aim: the true length is within the error bar. Only where RASTRO_PROGRAM names the program.
import assert from 'node:assert/strict';
import { before, test } from 'node:test';
import type { Page } from 'playwright-core';
import { drawn, faultsOf, screenshot } from './browser';
import { until } from './live_testing';
import { project, sharedBrowser, useBrowser } from './page_testing';
import { openCurrent, rastro, scratchFolder, serving, skip } from './program_testing';
import { random } from './scene_writer';

/** Those whose maps have surfaces to click on. */
const methods = ['rgbd', 'rtabmap'];
const folder = scratchFolder('shelf');
useBrowser();
before(() => {
  if (skip) return;
  rastro(folder, 'simulate', 'study', '--out', 'study', '--frames', '300', '--quiet');
  for (const method of methods) rastro(folder, 'slam', 'study', '--method', method, '--out', method, '--quiet');
});

/** Truth of the world `study`, seed 1: ends of the shelf's width, in the frame of the first camera. */
const [left, right, width] = [[0.22, -0.12, 2.06], [0.98, -0.14, 2.06], 0.75];

async function clickNear(page: Page, point: number[], aim: () => number): Promise<void> {
  const [x, y] = await project(page, point);
  await page.mouse.click(x + aim(), y + aim());
}

/** The last measured length, its error bar, and by what it was measured. */
async function lastLength(page: Page): Promise<{ length: number; sigma: number; note: string }> {
  const text = await page.locator('.lengths').innerText();
  const [, length, sigma] = /([\d.]+) ± ([\d.]+) m/.exec(await page.locator('.lengths .value').last().innerText())!.map(Number);
  return { length, sigma, note: text.split('\n').at(-1)! };
}

async function faceTheShelf(page: Page): Promise<void> {
  await page.evaluate(() => {
    const { app } = (window as any).rastro;
    app.set({ layers: Object.fromEntries(['reference', ...app.runs.flatMap((r: any) => r.layers.map((l: any) => l.key))].map((key) => [key, /^points:(cloud|landmarks)/.test(key)])) });
    app.view.controls.target.set(0.75, -0.13, 2.06);
    app.view.camera.position.set(0.7, -0.3, 0.5);
    app.view.controls.update();
    app.view.requestDraw();
  });
  await drawn(page);
}

for (const method of methods) {
  test(`the shelf in the map of ${method} is 0.75 m wide, within the error bar, by points and by edges`, { skip, timeout: 240_000 }, async (t) => {
    const { url, child } = await serving(folder, 'view', method, '--quiet');
    const page = await openCurrent(sharedBrowser(), url);
    try {
      await drawn(page);
      await faceTheShelf(page);
      const rnd = random(5);
      const aim = () => 6 * rnd() - 3;
      await page.keyboard.press('m');
      for (const kind of ['point', 'edge']) {
        await page.getByRole('button', { name: kind, exact: true }).click();
        for (let k = 0; k < 5; k++) {
          const before = await page.locator('.lengths .value').count();
          for (const end of [left, right]) await clickNear(page, end, aim);
          assert.equal(await page.locator('.lengths .value').count(), before + 1, await page.locator('.hint').innerText());
          if (kind === 'edge') await until(async () => ((await page.locator('.lengths').innerText()).match(/from the images of the keyframes|; in the images: /g) ?? []).length > k, 'an answer of the program', 30_000);
          const { length, sigma, note } = await lastLength(page);
          t.diagnostic(`${kind}: ${length.toFixed(4)} ± ${sigma.toFixed(4)} m ${note}`);
          assert.ok(Math.abs(length - width) <= sigma && sigma < 0.1, `${kind}: ${length} ± ${sigma}`);
        }
      }
      await screenshot(page, `shelf_${method}`);
      assert.deepEqual(faultsOf(page), []);
    } finally {
      await page.close();
      child.kill();
    }
  });
}
