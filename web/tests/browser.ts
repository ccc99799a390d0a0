// SPDX-License-Identifier: Apache-2.0
// Opens the built page in Debian's Chromium, with software WebGL, and reads its picture.
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { resolve } from 'node:path';
import { inflateSync } from 'node:zlib';
import { chromium, type Browser, type BrowserContext, type Page } from 'playwright-core';

export const out = resolve('test_out');

export function launch(): Promise<Browser> {
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
      '--disable-component-update', '--disable-sync', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });
}

/** A file of the page with scenes in it, as `rastro export --to html` writes it. */
export function pageWith(file: string, scenes: { name: string; bytes: Uint8Array }[]): string {
  const scripts = scenes.map(({ name, bytes }) => `<script type="application/octet-stream;base64" class="rastro-scene" data-name="${name}">${Buffer.from(bytes).toString('base64')}</script>`);
  const marker = '<!-- rastro-scenes -->';
  const [head, tail] = readFileSync('dist/viewer.html', 'utf8').split(marker);
  mkdirSync(out, { recursive: true });
  writeFileSync(`${out}/${file}`, [head, marker, ...scripts, tail].join('\n'));
  return `file://${out}/${file}`;
}

export interface Options {
  width?: number;
  height?: number;
  dark?: boolean;
}

/** A page that fails the test on any error of its script and on any request beyond the file. */
export async function open(browser: Browser | BrowserContext, url: string, options: Options = {}): Promise<Page> {
  const { width = 1280, height = 800, dark = true } = options;
  const settings = { viewport: { width, height }, colorScheme: dark ? 'dark' : 'light', hasTouch: width < 500 } as const;
  const page = 'newContext' in browser ? await (browser as Browser).newPage(settings) : await (browser as BrowserContext).newPage();
  const faults: string[] = [];
  page.on('pageerror', (error) => faults.push(String(error)));
  page.on('console', (message) => message.type() === 'error' && faults.push(message.text()));
  page.on('request', (r) => /^https?:/.test(r.url()) && !r.url().startsWith(new URL(url).origin) && faults.push(`request to ${r.url()}`));
  Object.assign(page, { faults });
  await page.goto(url);
  return page;
}

export function faultsOf(page: Page): string[] {
  return (page as unknown as { faults: string[] }).faults;
}

/** Waits until the whole picture is drawn. */
export async function drawn(page: Page): Promise<void> {
  await page.waitForFunction(() => {
    const { rastro } = window as any;
    return rastro.ready && rastro.stats.completePictureMs !== null && rastro.stats.tilesWaiting === 0 && rastro.stats.pointsDrawn === rastro.stats.pointsVisible;
  }, undefined, { timeout: 15000 });
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

export interface Picture {
  width: number;
  height: number;
  at: (x: number, y: number) => [number, number, number];
}

export async function screenshot(page: Page, name: string): Promise<Picture> {
  const file = `${out}/${name}.png`;
  await page.screenshot({ path: file });
  return readPng(readFileSync(file));
}

/** Just enough of PNG for Chromium's screenshots: 8 bits, RGB or RGBA, not interlaced. */
export function readPng(file: Buffer): Picture {
  const [width, height, channels] = [file.readUInt32BE(16), file.readUInt32BE(20), file[25] === 6 ? 4 : 3];
  const parts: Buffer[] = [];
  for (let i = 8; i < file.length; i += 12 + file.readUInt32BE(i)) {
    if (file.toString('latin1', i + 4, i + 8) === 'IDAT') parts.push(file.subarray(i + 8, i + 8 + file.readUInt32BE(i)));
  }
  const rows = inflateSync(Buffer.concat(parts));
  const stride = width * channels;
  const pixels = Buffer.alloc(height * stride);
  for (let y = 0; y < height; y++) unfilter(rows, pixels, y, stride, channels);
  return { width, height, at: (x, y) => [...pixels.subarray(y * stride + x * channels, y * stride + x * channels + 3)] as [number, number, number] };
}

function unfilter(rows: Buffer, pixels: Buffer, y: number, stride: number, channels: number): void {
  const filter = rows[y * (stride + 1)];
  for (let i = 0; i < stride; i++) {
    const left = i >= channels ? pixels[y * stride + i - channels] : 0;
    const above = y > 0 ? pixels[(y - 1) * stride + i] : 0;
    const corner = i >= channels && y > 0 ? pixels[(y - 1) * stride + i - channels] : 0;
    const guess = [0, left, above, (left + above) >> 1, paeth(left, above, corner)][filter];
    pixels[y * stride + i] = (rows[y * (stride + 1) + 1 + i] + guess) & 255;
  }
}

function paeth(left: number, above: number, corner: number): number {
  const p = left + above - corner;
  const [a, b, c] = [Math.abs(p - left), Math.abs(p - above), Math.abs(p - corner)];
  return a <= b && a <= c ? left : b <= c ? above : corner;
}
