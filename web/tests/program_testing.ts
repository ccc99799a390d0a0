// SPDX-License-Identifier: Apache-2.0
// What the tests with the program itself share. They need it and take minutes: only where RASTRO_PROGRAM names it.
import { execFileSync, spawn, type ChildProcess } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { resolve } from 'node:path';
import { after } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import { open } from './browser';
import { contentPolicy } from './serve';

export const program = resolve(process.env.RASTRO_PROGRAM ?? '');
export const skip = !process.env.RASTRO_PROGRAM;

/** A folder for what the program makes, until the tests of the file have ended. */
export function scratchFolder(name: string): string {
  const folder = mkdtempSync(`${tmpdir()}/rastro_${name}_`);
  after(() => rmSync(folder, { recursive: true, force: true }));
  return folder;
}

/** Runs the program in a folder; throws where it does not end with 0. */
export function rastro(folder: string, ...words: string[]): void {
  execFileSync(program, words, { cwd: folder, stdio: ['ignore', 'ignore', 'inherit'] });
}

/** Starts a command that serves a page, and waits for its address. */
export async function serving(folder: string, ...words: string[]): Promise<{ url: string; child: ChildProcess; seconds: number }> {
  const begin = performance.now();
  const child = spawn(program, [...words, '--port', '0'], { cwd: folder, stdio: ['ignore', 'pipe', 'pipe'] });
  const url = await new Promise<string>((done, fail) => {
    let text = '';
    const read = (part: unknown) => {
      text += String(part);
      const found = /http:\/\/\S+/.exec(text);
      if (found) done(found[0]);
    };
    child.stdout!.on('data', read);
    child.stderr!.on('data', read);
    child.once('exit', (code) => fail(new Error(`rastro ${words[0]} ended with ${code}: ${text}`)));
  });
  return { url, child, seconds: (performance.now() - begin) / 1000 };
}

/** The program's scenes in the page as it is built now, not as it was packed into the program. */
export async function openCurrent(browser: Browser, url: string, hash = ''): Promise<Page> {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, colorScheme: 'dark' });
  await context.route(url, (route) => route.fulfill({ body: readFileSync('dist/viewer.html'), contentType: 'text/html', headers: { 'content-security-policy': contentPolicy } }));
  return open(context, `${url}${hash}`);
}
