// SPDX-License-Identifier: Apache-2.0
// Clouds of many millions of points, served by the program in tiles: first picture, memory of the tab, time of a picture
// while orbiting. Only where RASTRO_PROGRAM names the program; RASTRO_WEB_POINTS sets how many points (5 million).
import assert from 'node:assert/strict';
import { closeSync, openSync, readFileSync, readdirSync, writeSync } from 'node:fs';
import { test } from 'node:test';
import type { Page } from 'playwright-core';
import { faultsOf, launch, open, pageWith, screenshot } from './browser';
import { colors } from './page_testing';
import { openCurrent, scratchFolder, serving, skip } from './program_testing';
import { random } from './scene_writer';
import { exactScene } from './scenes';

const points = Number(process.env.RASTRO_WEB_POINTS ?? 5e6);
const limitMs = Number(process.env.RASTRO_WEB_LIMIT_MS ?? 3000);
const mostTabMb = 1500;
const folder = scratchFolder('large');

/** Floors and walls of a building of 200 x 100 m with rooms of 10 m, as a PLY file: x y z, red green blue. */
function writeCloud(file: string): void {
  const rnd = random(11);
  const out = openSync(file, 'w');
  writeSync(out, `ply\nformat binary_little_endian 1.0\nelement vertex ${points}\nproperty float x\nproperty float y\nproperty float z\n`
    + 'property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n');
  const bytes = Buffer.alloc(15 * 100_000);
  for (let done = 0; done < points; done += 100_000) {
    const count = Math.min(100_000, points - done);
    for (let i = 0; i < count; i++) {
      const [a, b, side] = [rnd(), rnd(), rnd()];
      const p = side < 0.4 ? [200 * a, 100 * b, 0] : side < 0.7 ? [10 * Math.floor(21 * rnd()), 100 * a, 3 * b] : [200 * a, 10 * Math.floor(11 * rnd()), 3 * b];
      p.forEach((v, axis) => bytes.writeFloatLE(v, 15 * i + 4 * axis));
      bytes.set(side < 0.4 ? [120, 110, 100] : side < 0.7 ? [200, 80, 60] : [60, 120, 200], 15 * i + 12);
    }
    writeSync(out, bytes, 0, 15 * count);
  }
  closeSync(out);
}

/** Memory that the processes below this one have for themselves, and their share of what is common, by kind. */
function memoryMb(kind: string): number {
  const parents = new Map<number, number>();
  for (const pid of readdirSync('/proc').filter((name) => /^\d+$/.test(name)).map(Number)) {
    try {
      parents.set(pid, Number(/^PPid:\s+(\d+)/m.exec(readFileSync(`/proc/${pid}/status`, 'latin1'))![1]));
    } catch { /* it has ended */ }
  }
  const isOurs = (pid: number): boolean => pid === process.pid || (parents.has(pid) && isOurs(parents.get(pid)!));
  return [...parents.keys()].filter(isOurs).reduce((most, pid) => {
    try {
      if (!readFileSync(`/proc/${pid}/cmdline`, 'latin1').includes(kind)) return most;
      return Math.max(most, Number(/^Pss:\s+(\d+)/m.exec(readFileSync(`/proc/${pid}/smaps_rollup`, 'latin1'))![1]) / 1e3);
    } catch {
      return most;
    }
  }, 0);
}

test(`${points} points in a file stay usable`, { skip, timeout: 300_000 }, async (t) => {
  writeCloud(`${folder}/cloud.ply`);
  const { url, child, seconds } = await serving(folder, 'view', 'cloud.ply', '--quiet');
  const browser = await launch();
  try {
    // The browser's own start is not the page's time.
    const first = await open(browser, pageWith('first.html', [{ name: 'exact', bytes: exactScene() }]));
    await first.waitForFunction(() => (window as any).rastro.stats?.firstPictureMs);
    await first.close();
    const page = await openCurrent(browser, url);
    await page.waitForFunction(() => (window as any).rastro.stats?.firstPictureMs, undefined, { timeout: 60000 });
    const firstMs = await page.evaluate(() => (window as any).rastro.stats.firstPictureMs as number);
    await complete(page);
    const wholeMs = await page.evaluate(() => (window as any).rastro.stats.completePictureMs as number);
    const picture = await screenshot(page, `large_${points}`);
    const seen = colors(picture, 340, 230, 1230, 570);
    for (const color of ['120,110,100', '200,80,60', '60,120,200']) assert.ok(seen.has(color), `${color} is missing`);
    const times = await page.evaluate(walk);
    await complete(page);
    await screenshot(page, `large_${points}_inside`);
    const [tab, gpu] = [memoryMb('--type=renderer'), memoryMb('--type=gpu-process')];
    const stats = await page.evaluate(() => (window as any).rastro.stats);
    t.diagnostic(`server ready after ${seconds.toFixed(1)} s with ${Math.round(residentMb(child.pid!))} MB; first picture ${Math.round(firstMs)} ms, whole ${Math.round(wholeMs)} ms; `
      + `a picture while orbiting ${times.median.toFixed(0)} ms (median), ${times.worst.toFixed(0)} ms (95 %); tab ${Math.round(tab)} MB, graphics process ${Math.round(gpu)} MB; ${stats.pointsVisible} points in the last picture`);
    assert.deepEqual(faultsOf(page), []);
    assert.ok(tab > 0 && tab + gpu <= mostTabMb, `the tab takes ${tab} MB and its graphics ${gpu} MB`);
    assert.ok(firstMs <= limitMs, `first picture after ${firstMs} ms`);
  } finally {
    child.kill();
    await browser.close();
  }
});

function residentMb(pid: number): number {
  return Number(/^VmHWM:\s+(\d+)/m.exec(readFileSync(`/proc/${pid}/status`, 'latin1'))![1]) / 1e3;
}

async function complete(page: Page): Promise<void> {
  await page.waitForFunction(() => {
    const { stats } = (window as any).rastro;
    return stats.completePictureMs !== null && stats.tilesWaiting === 0 && stats.pointsDrawn === stats.pointsVisible;
  }, undefined, { timeout: 120_000 });
}

/** Times between pictures while the eye goes around the building, then through it, for tiles to come and go. */
async function walk(): Promise<{ median: number; worst: number }> {
  const { view } = (window as any).rastro.app;
  const times: number[] = [];
  let last = performance.now();
  const to = async (eye: [number, number, number], target: [number, number, number]) => {
    view.camera.position.set(...eye);
    view.controls.target.set(...target);
    view.controls.update();
    view.requestDraw();
    await new Promise((done) => requestAnimationFrame(done));
    times.push(performance.now() - last);
    last = performance.now();
  };
  for (let i = 0; i < 60; i++) await to([100 + 150 * Math.cos(i / 10), 50 + 150 * Math.sin(i / 10), 80], [100, 50, 0]);
  for (let i = 0; i < 120; i++) await to([2 + 1.6 * i, 55, 1.6], [12 + 1.6 * i, 56, 1.4]);
  times.sort((a, b) => a - b);
  return { median: times[Math.floor(times.length / 2)], worst: times[Math.floor(0.95 * times.length)] };
}
