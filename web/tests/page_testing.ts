// SPDX-License-Identifier: Apache-2.0
// What the tests in a browser share: one browser a file, a page that must end without faults, pixels and pictures.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { after, before } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import { drawn, faultsOf, launch, open, pageWith, screenshot, type Picture } from './browser';
import { exactScene, floorScene, roomScene, shelfScene } from './scenes';

let browser: Browser;

/** Pages that several tests open; made anew by each file of tests. */
export const urls: Record<string, string> = {};

export function sharedBrowser(): Browser {
  return browser;
}

/** To be called once at the top of a file of tests. */
export function useBrowser(): void {
  before(async () => {
    browser = await launch();
    urls.room = pageWith('room.html', [{ name: 'room', bytes: roomScene({ points: 4000 }) }]);
    urls.floor = pageWith('floor.html', [{ name: 'floor', bytes: floorScene() }]);
    urls.shelf = pageWith('shelf.html', [{ name: 'shelf', bytes: shelfScene() }]);
    urls.exact = pageWith('exact.html', [{ name: 'exact', bytes: exactScene() }]);
    urls.arbitrary = pageWith('arbitrary.html', [{ name: 'exact', bytes: exactScene({ kind: 'arbitrary' }) }]);
  });
  after(() => browser.close());
}

export async function withPage(url: string, options: Parameters<typeof open>[2], use: (page: Page) => Promise<void>): Promise<void> {
  const page = await open(sharedBrowser(), url, options);
  try {
    await use(page);
    assert.deepEqual(faultsOf(page), []);
  } finally {
    await page.close();
  }
}

export function project(page: Page, point: number[]): Promise<[number, number]> {
  return page.evaluate((p) => (window as any).rastro.project(p), point);
}

export function colors(picture: Picture, x0: number, y0: number, x1: number, y1: number): Set<string> {
  const found = new Set<string>();
  for (let y = y0; y < y1; y += 2) for (let x = x0; x < x1; x += 2) found.add(picture.at(x, y).join());
  return found;
}

export async function canvasPicture(page: Page): Promise<string> {
  await drawn(page);
  const data = await page.evaluate(() => document.querySelector('canvas')!.toDataURL());
  return createHash('sha256').update(data).digest('hex');
}

export async function pixelAt(page: Page, point: number[], name: string): Promise<[number, number, number]> {
  const [x, y] = await project(page, point);
  return (await screenshot(page, name)).at(Math.round(x), Math.round(y));
}

export function near(actual: number[], expected: number[], tolerance = 3): void {
  assert.ok(actual.every((v, i) => Math.abs(v - expected[i]) <= tolerance), `${actual} is not ${expected}`);
}

export async function clickPoint(page: Page, point: number[]): Promise<void> {
  await page.mouse.click(...(await project(page, point)));
}
