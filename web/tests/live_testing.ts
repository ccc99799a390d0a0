// SPDX-License-Identifier: Apache-2.0
// What the tests of live runs share: a server, a page on it, waiting for what the page shows.
import assert from 'node:assert/strict';
import type { Page } from 'playwright-core';
import { faultsOf, open } from './browser';
import { LiveServer } from './live_server';
import { hello, status } from './live_run';
import { sharedBrowser } from './page_testing';

type Options = Parameters<typeof open>[2];

/** Faults that a lost server makes in the browser's console are the browser's own words, not the page's. */
const ofNetwork = /WebSocket|Failed to load resource|ERR_|net::/;

export async function withRun(options: Options, use: (page: Page, server: LiveServer) => Promise<void>, prepare: (server: LiveServer) => void = () => {}): Promise<void> {
  const server = new LiveServer('abc');
  server.greeting = [hello(), status()];
  prepare(server);
  await server.open();
  const page = await open(sharedBrowser(), server.url, options);
  try {
    await page.waitForFunction(() => (window as any).rastro.live?.hello);
    await use(page, server);
  } catch (error) {
    console.log(faultsOf(page).slice(0, 5).join('\n'));
    throw error;
  } finally {
    await page.close();
    await server.close();
  }
  assert.deepEqual(faultsOf(page).filter((fault) => !ofNetwork.test(fault)), []);
}

export async function shownFrame(page: Page, index: number): Promise<void> {
  await page.waitForFunction((i) => document.querySelector<HTMLElement>('.frame-view')!.dataset.frame === `${i}`, index, { timeout: 10000 });
}

export async function shownImage(page: Page, index: number): Promise<void> {
  await page.waitForFunction((i) => document.querySelector<HTMLElement>('.frame-view')!.dataset.image === `${i}`, index, { timeout: 10000 });
}

export function runState(page: Page, text: string | RegExp): Promise<void> {
  return page.locator('.run-state', { hasText: text }).waitFor({ timeout: 30000 });
}

export async function until(what: () => boolean | Promise<boolean>, name: string, ms = 10000): Promise<void> {
  const end = Date.now() + ms;
  while (!(await what())) {
    if (Date.now() > end) assert.fail(`${name} did not happen`);
    await wait(20);
  }
}

export function wait(ms: number): Promise<void> {
  return new Promise((done) => setTimeout(done, ms));
}

export function median(values: number[]): number {
  return [...values].sort((a, b) => a - b)[values.length >> 1];
}
