// SPDX-License-Identifier: Apache-2.0
// A run in a browser: how soon a frame is shown, many frames at once, damaged messages.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { damaged, damagedText } from './damage';
import { corridorJpeg, frame, hello, image, lostFrame, manyFeatures, mapScene, status } from './live_run';
import { median, runState, shownFrame, until, wait, withRun } from './live_testing';
import { useBrowser } from './page_testing';
import { random } from './scene_writer';

useBrowser();

const limitMs = Number(process.env.RASTRO_WEB_LIVE_LIMIT_MS ?? 100);

test(`a frame is on the page within ${limitMs} ms, at 20 frames and 10 images a second`, () => withRun({}, async (page, server) => {
  const jpeg = await corridorJpeg(page, 640, 480);
  server.scene = mapScene(1, 40);
  server.send({ type: 'scene', index: 0, revision: 1 });
  await page.locator('[data-layer="points:landmarks"]').waitFor();
  // What a picture of the page holds, independent of the page's own words for it.
  await page.evaluate(() => {
    const seen: [number, number, string][] = [];
    const look = () => {
      const { frame: at, image: shown } = document.querySelector<HTMLElement>('.frame-view')!.dataset;
      if (at !== undefined && seen[seen.length - 1]?.[2] !== `${at} ${shown}`) seen.push([Number(at), Date.now(), `${at} ${shown}`]);
      requestAnimationFrame(look);
    };
    Object.assign(window, { seen });
    look();
  });
  const sent = new Map<number, number>();
  for (let i = 400; i < 470; i++) {
    if (i % 2 === 0) server.sendBytes(image(i, { jpeg, ...manyFeatures(800, i) }));
    sent.set(i, Date.now());
    server.send(frame(i));
    await wait(50);
  }
  await shownFrame(page, 469);
  await wait(100);
  const seen = await page.evaluate(() => (window as any).seen as [number, number, string][]);
  const first = (i: number, of: (s: [number, number, string]) => number) => seen.find((s) => of(s) >= i)?.[1] ?? Infinity;
  const frames = [...sent].map(([i, at]) => first(i, (s) => s[0]) - at);
  const images = [...sent].filter(([i]) => i % 2 === 0).map(([i, at]) => first(i, (s) => Number(s[2].split(' ')[1])) - at);
  console.log(`frame shown after ${median(frames)} ms (median), at most ${Math.max(...frames)} ms; image after ${median(images)} ms (median)`);
  assert.ok(median(frames) <= limitMs, `${median(frames)} ms`);
}));

test('5000 frames at once: the page answers, and all are there', () => withRun({}, async (page, server) => {
  const jpeg = await corridorJpeg(page, 320, 240);
  const begin = Date.now();
  for (let i = 0; i < 5000; i++) {
    server.send(i % 500 < 40 ? lostFrame(i) : frame(i));
    if (i % 100 === 0) server.sendBytes(image(i, { jpeg, ...manyFeatures(300, i) }));
  }
  const answers: number[] = [];
  await until(async () => {
    const asked = Date.now();
    const count = await page.evaluate(() => new Promise<number>((done) => requestAnimationFrame(() => done((window as any).rastro.live.record.count))));
    answers.push(Date.now() - asked);
    return count === 5000;
  }, '5000 frames', 20000);
  await shownFrame(page, 4999);
  const took = Date.now() - begin;
  // The same again, as a long run goes on.
  const longest = await page.evaluate(async () => {
    let [last, worst] = [performance.now(), 0];
    for (let i = 0; i < 30; i++) {
      await new Promise((done) => requestAnimationFrame(done));
      worst = Math.max(worst, performance.now() - last);
      last = performance.now();
    }
    return worst;
  });
  console.log(`5000 frames shown after ${took} ms; slowest answer ${Math.max(...answers)} ms, longest wait between pictures afterwards ${Math.round(longest)} ms`);
  assert.ok(took < 8000 && Math.max(...answers) < 2000, `${took} ${answers}`);
}));

test('2000 damaged messages break nothing; one plain line counts them', () => withRun({}, async (page, server) => {
  const rnd = random(77);
  const jpeg = await corridorJpeg(page, 320, 240);
  for (let i = 0; i < 20; i++) server.send(frame(i));
  server.scene = mapScene(1, 3);
  const block = image(21, { jpeg, ...manyFeatures(50, 1) });
  for (let i = 0; i < 2000; i++) {
    const whole = [hello(), status({ line: 'x' }), frame(20 + (i >> 3)), lostFrame(20 + (i >> 3)), { type: 'scene', index: 0, revision: i }, frame(20 + (i >> 3), { events: [{ kind: 'loop_closed', detail: 'x' }] })];
    if (i % 5 === 4) server.sendBytes(damaged(block, rnd));
    else server.sendText(damagedText(JSON.stringify(whole[i % whole.length]), rnd));
    if (i % 100 === 0) {
      server.scene = damaged(mapScene(i, 3), rnd);
      await wait(10);
    }
  }
  await page.locator('.run-fault', { hasText: /unreadable/ }).waitFor();
  server.scene = mapScene(5000, 4);
  server.send(hello());
  server.send(status({ line: 'all sent' }));
  server.send({ type: 'scene', index: 0, revision: 5000 });
  await page.locator('.facts', { hasText: /revision 5[ ,]?000/ }).waitFor();
  await runState(page, 'running');
  // A last frame behind all that is damaged: damaged ones may claim later times and numbers.
  await until(async () => (await page.evaluate(() => (window as any).rastro.live.status.line as string)) === 'all sent', 'the last status', 30000);
  const { lastStamp, lastIndex } = await page.evaluate(() => ({ lastStamp: (window as any).rastro.live.record.lastStamp as number, lastIndex: (window as any).rastro.live.record.lastIndex as number }));
  server.send(frame(lastIndex + 1, { stamp: lastStamp + 1 }));
  await shownFrame(page, lastIndex + 1);
  console.log(await page.locator('.run-fault').getAttribute('title'));
}));
