// SPDX-License-Identifier: Apache-2.0
// The built page in a browser: what is drawn, where, and what the controls do.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import { damaged } from './damage';
import { stateNames, exactScene, floorScene, hollowScene, imagesScene, roomScene } from './scenes';
import { drawn, faultsOf, launch, open, pageWith, screenshot, type Picture } from './browser';
import { SceneWriter, random } from './scene_writer';
import { serve } from './serve';

let browser: Browser;
const urls: Record<string, string> = {};

before(async () => {
  browser = await launch();
  urls.room = pageWith('room.html', [{ name: 'room', bytes: roomScene({ points: 4000 }) }]);
  urls.floor = pageWith('floor.html', [{ name: 'floor', bytes: floorScene() }]);
  urls.exact = pageWith('exact.html', [{ name: 'exact', bytes: exactScene() }]);
  urls.arbitrary = pageWith('arbitrary.html', [{ name: 'exact', bytes: exactScene({ kind: 'arbitrary' }) }]);
});

after(() => browser.close());

async function withPage(url: string, options: Parameters<typeof open>[2], use: (page: Page) => Promise<void>): Promise<void> {
  const page = await open(browser, url, options);
  try {
    await use(page);
    assert.deepEqual(faultsOf(page), []);
  } finally {
    await page.close();
  }
}

function project(page: Page, point: number[]): Promise<[number, number]> {
  return page.evaluate((p) => (window as any).rastro.project(p), point);
}

function colors(picture: Picture, x0: number, y0: number, x1: number, y1: number): Set<string> {
  const found = new Set<string>();
  for (let y = y0; y < y1; y += 2) for (let x = x0; x < x1; x += 2) found.add(picture.at(x, y).join());
  return found;
}

async function canvasPicture(page: Page): Promise<string> {
  await drawn(page);
  const data = await page.evaluate(() => document.querySelector('canvas')!.toDataURL());
  return createHash('sha256').update(data).digest('hex');
}

async function pixelAt(page: Page, point: number[], name: string): Promise<[number, number, number]> {
  const [x, y] = await project(page, point);
  return (await screenshot(page, name)).at(Math.round(x), Math.round(y));
}

function near(actual: number[], expected: number[], tolerance = 3): void {
  assert.ok(actual.every((v, i) => Math.abs(v - expected[i]) <= tolerance), `${actual} is not ${expected}`);
}

for (const [name, options] of Object.entries({ dark: { dark: true }, light: { dark: false }, narrow: { width: 390, height: 844 } })) {
  test(`the room is drawn, ${name}`, () => withPage(urls.room, options, async (page) => {
    await drawn(page);
    const picture = await screenshot(page, `room_${name}`);
    assert.ok(colors(picture, picture.width - 380, 80, picture.width - 10, 600).size > 100);
  }));
}

test('points are drawn at the pixels that project() says, in their colors', () => withPage(`${urls.exact}#size=7&layers=-reference`, {}, async (page) => {
  await drawn(page);
  const picture = await screenshot(page, 'exact');
  const expected = [[[0, 0, 0], [255, 0, 0]], [[1, 0, 0], [0, 255, 0]], [[1, 2, 0], [0, 0, 255]], [[0, 2, 0], [255, 0, 255]], [[0.5, 1, 0.75], [0, 255, 255]]];
  for (const [point, color] of expected) {
    const [x, y] = await project(page, point);
    near(picture.at(Math.round(x), Math.round(y)), color);
    near(picture.at(Math.round(x) + 8, Math.round(y)), [20, 24, 29]);
  }
}));

test('height colors: lowest violet, highest yellow of viridis', () => withPage(`${urls.exact}#size=7&layers=-reference&points=height`, {}, async (page) => {
  await drawn(page);
  near(await pixelAt(page, [0, 0, 0], 'height'), [0x44, 0x01, 0x54]);
  near(await pixelAt(page, [0.5, 1, 0.75], 'height'), [0xfd, 0xe7, 0x25]);
}));

test('points above the largest sigma are hidden', () => withPage(`${urls.exact}#size=7&layers=-reference&sigma=0.015`, {}, async (page) => {
  await drawn(page);
  near(await pixelAt(page, [1, 2, 0], 'filtered'), [0, 0, 255]);
  near(await pixelAt(page, [0, 2, 0], 'filtered'), [20, 24, 29]);
}));

test('a planar map is seen from above: x right, y up', () => withPage(urls.floor, {}, async (page) => {
  await drawn(page);
  const [o, x, y] = [await project(page, [0, 0, 0]), await project(page, [1, 0, 0]), await project(page, [0, 1, 0])];
  assert.ok(x[0] - o[0] > 20 && Math.abs(x[1] - o[1]) < 1);
  assert.ok(o[1] - y[1] > 20 && Math.abs(y[0] - o[0]) < 1);
  near(await pixelAt(page, [0, 1, 0], 'floor'), [65, 65, 65], 12);
}));

for (const scene of ['room', 'floor']) {
  test(`each layer switch changes the picture, ${scene}`, () => withPage(urls[scene], {}, async (page) => {
    await drawn(page);
    for (const key of await page.$$eval('[data-layer]', (boxes) => boxes.map((b) => (b as HTMLElement).dataset.layer!))) {
      const before = await canvasPicture(page);
      await page.click(`[data-layer="${key}"]`);
      assert.notEqual(await canvasPicture(page), before, `${key} changes nothing`);
      await page.click(`[data-layer="${key}"]`);
      assert.equal(await canvasPicture(page), before, `${key} does not come back`);
    }
  }));
}

test('runs over each other have their own colors and switches', async () => {
  const url = pageWith('two.html', [{ name: 'first', bytes: exactScene() }, { name: 'second', bytes: exactScene() }]);
  await withPage(`${url}#size=7&layers=-reference`, {}, async (page) => {
    await drawn(page);
    await page.getByLabel('second').uncheck();
    near(await pixelAt(page, [1, 0, 0], 'first'), [0x56, 0xb4, 0xe9]);
    await page.getByLabel('second').check();
    await page.getByLabel('first').uncheck();
    near(await pixelAt(page, [1, 0, 0], 'second'), [0xe6, 0x9f, 0x00]);
  });
});

test('scrubbing, keys and playing move the current frame', () => withPage(urls.room, {}, async (page) => {
  await drawn(page);
  const strip = (await page.locator('.strip canvas').boundingBox())!;
  const place = () => page.evaluate(() => {
    const { app } = (window as any).rastro;
    const { frame } = app.state;
    return { frame, p: [...app.frames.positions.subarray(3 * frame, 3 * frame + 3)] as number[] };
  });
  const yellow = async () => near(await pixelAt(page, (await place()).p, 'scrub'), [0xf0, 0xe4, 0x42], 6);
  for (const share of [0.25, 0.5, 0.75]) {
    await page.mouse.click(strip.x + 12 + share * (strip.width - 24), strip.y + 40);
    await drawn(page);
    assert.ok(Math.abs((await place()).frame - share * 399) <= 1);
    await yellow();
  }
  const { frame } = await place();
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('Shift+ArrowRight');
  assert.equal((await place()).frame, frame + 11);
  await page.keyboard.press('[');
  assert.equal((await place()).frame, 180);
  assert.match(await page.locator('.frame').innerText(), /relocalized: in keyframe 14/);
  await page.getByLabel('Play').click();
  await page.waitForFunction(() => (window as any).rastro.app.state.frame > 190);
  await page.getByLabel('Pause').click();
}));

async function clickPoint(page: Page, point: number[]): Promise<void> {
  await page.mouse.click(...(await project(page, point)));
}

test('two clicks measure the exact length with its error bar', () => withPage(urls.exact, {}, async (page) => {
  await drawn(page);
  await page.keyboard.press('m');
  await clickPoint(page, [0, 0, 0]);
  await clickPoint(page, [1, 0, 0]);
  assert.equal(await page.locator('.lengths .value').innerText(), '1.000 ± 0.005 m');
  assert.match(await page.locator('.labels').innerText(), /length 1 1\.000 ± 0\.005 m/);
  await clickPoint(page, [1, 1, 0]);
  assert.match(await page.locator('.hint').innerText(), /no point near/);
  await page.keyboard.press('Escape');
  assert.ok(await page.locator('.hint').isHidden());
  await screenshot(page, 'measured');
}));

test('a known length gives a map of arbitrary scale its meters', () => withPage(urls.arbitrary, {}, async (page) => {
  await drawn(page);
  await page.getByRole('button', { name: 'Measure' }).click();
  for (const p of [[0, 0, 0], [1, 0, 0], [1, 0, 0], [1, 2, 0]]) await clickPoint(page, p);
  assert.deepEqual(await page.locator('.lengths .value').allInnerTexts(), ['1.000 ± 0.005 units', '2.000 ± 0.011 units']);
  await page.getByLabel('Known length in meters').first().fill('0.75');
  await page.keyboard.press('Enter');
  const [first, second] = await page.locator('.lengths .value').allInnerTexts();
  assert.equal(first, '0.75 m (known)');
  assert.match(second, /^1\.500 ± 0\.011 m$/);
  assert.match(await page.locator('[data-layer="reference"]').innerText(), /cell [\d.]+ m/);
  await screenshot(page, 'scaled');
}));

test('the address restores view, layers, frame and colors', () => withPage(urls.room, {}, async (page) => {
  await drawn(page);
  await page.keyboard.press('End');
  await page.keyboard.press('a');
  await page.keyboard.press('8');
  await page.locator('select[aria-label="Color"]').nth(1).selectOption('age');
  await page.waitForFunction(() => location.hash.includes('points=age') && location.hash.includes('frame=399'));
  const [before, hash] = [await project(page, [1, 0.5, 1]), await page.evaluate(() => location.hash)];
  await withPage(`${urls.room}${hash}`, {}, async (again) => {
    await drawn(again);
    near(await project(again, [1, 0.5, 1]), before, 0.2);
    assert.equal(await again.evaluate(() => (window as any).rastro.app.state.frame), 399);
    assert.equal(await again.locator('select[aria-label="Color"]').nth(1).inputValue(), 'age');
    assert.equal(await again.locator('[data-layer="points:landmarks"] input').isChecked(), false);
  });
}));

test('a link opened in the same tab is followed', () => withPage(urls.room, {}, async (page) => {
  await drawn(page);
  await page.evaluate(() => {
    location.hash = '#frame=200&layers=-keyframes&view=0,-9,0.01,0,0,0';
  });
  await page.waitForFunction(() => (window as any).rastro.app.state.frame === 200);
  assert.equal(await page.locator('[data-layer="keyframes"] input').isChecked(), false);
  near(await page.evaluate(() => (window as any).rastro.app.view.camera.position.toArray()), [0, -9, 0.01], 0.01);
}));

test('the view follows the current frame, and looks from its camera', () => withPage(urls.room, {}, async (page) => {
  await drawn(page);
  const target = () => page.evaluate(() => (window as any).rastro.app.view.controls.target.toArray());
  const position = () => page.evaluate(() => {
    const { app } = (window as any).rastro;
    return [...app.frames.positions.subarray(3 * app.state.frame, 3 * app.state.frame + 3)] as number[];
  });
  await page.keyboard.press('v');
  near(await target(), await position(), 1e-5);
  await page.keyboard.press('Shift+ArrowRight');
  near(await target(), await position(), 1e-5);
  await page.keyboard.press('c');
  near(await page.evaluate(() => (window as any).rastro.app.view.camera.position.toArray()), await position(), 1e-5);
}));

test('the image of the nearest keyframe is shown; one that cannot be read is not', async () => {
  const maker = await browser.newPage();
  const jpeg = await maker.evaluate(() => document.createElement('canvas').toDataURL('image/jpeg').split(',')[1]);
  await maker.close();
  const url = pageWith('images.html', [{ name: 'images', bytes: imagesScene([Buffer.from(jpeg, 'base64'), Buffer.from('no image')]) }]);
  await withPage(url, {}, async (page) => {
    await page.locator('.frame img').waitFor({ state: 'visible' });
    assert.ok(await page.locator('.frame img').evaluate((image) => (image as HTMLImageElement).naturalWidth > 0));
    await page.keyboard.press('End');
    await page.locator('.frame img').waitFor({ state: 'hidden' });
  });
});

test('nothing is drawn while nothing changes', () => withPage(urls.room, {}, async (page) => {
  await drawn(page);
  const pictures = () => page.evaluate(() => (window as any).rastro.stats.pictures);
  const before = await pictures();
  await page.evaluate(async () => {
    for (let i = 0; i < 20; i++) await new Promise((done) => requestAnimationFrame(done));
  });
  assert.equal(await pictures(), before);
}));

test('390 pixels wide: nothing sticks out, the drawer opens, a tap measures', () => withPage(urls.exact, { width: 390, height: 844 }, async (page) => {
  await drawn(page);
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
  for (const part of ['.bar', '.view', '.timeline']) {
    const box = (await page.locator(part).boundingBox())!;
    assert.ok(box.x >= 0 && box.x + box.width <= 390 && box.y + box.height <= 844, part);
  }
  for (const tool of await page.locator('.tools button').all()) assert.ok((await tool.boundingBox())!.width >= 28);
  await page.locator('.menu').click();
  await page.locator('[data-layer="points:cloud"]').click();
  await screenshot(page, 'narrow_drawer');
  await page.locator('[data-layer="points:cloud"]').click();
  await page.locator('.menu').click();
  await page.getByRole('button', { name: 'Measure' }).tap();
  for (const p of [[0, 0, 0], [1, 0, 0]]) await page.touchscreen.tap(...(await project(page, p)));
  assert.match(await page.locator('.labels').innerText(), /1\.000 ± 0\.005 m/);
}));

test('a malformed scene is named, the others are shown', async () => {
  const url = pageWith('malformed.html', [{ name: 'broken', bytes: roomScene().subarray(0, 9000) }, { name: 'good', bytes: exactScene() }]);
  await withPage(url, {}, async (page) => {
    await drawn(page);
    assert.match(await page.getByRole('alert').innerText(), /^broken cannot be shown: .*cut off/);
    assert.equal(await page.title(), 'exact · rastro view');
  });
  const alone = pageWith('malformed_alone.html', [{ name: 'broken', bytes: new Uint8Array(5) }]);
  await withPage(alone, {}, async (page) => {
    assert.match(await page.getByRole('alert').innerText(), /broken cannot be shown: the scene has only 5 bytes/);
    await screenshot(page, 'malformed');
  });
});

test('damaged scenes never break the page', async () => {
  const rnd = random(7);
  const originals = [roomScene({ points: 300 }), floorScene(), exactScene()];
  const scenes = Array.from({ length: 45 }, (_, i) => ({ name: `damage ${i}`, bytes: damaged(originals[i % 3], rnd) }));
  await withPage(pageWith('damaged.html', scenes), {}, async (page) => {
    await drawn(page);
    const refused = await page.getByRole('alert').count();
    const { shown } = await page.evaluate(() => ({ shown: (window as any).rastro.app.runs.length }));
    assert.equal(refused + shown, 45);
    assert.ok(refused > 10 && shown > 5, `${refused} refused`);
    for (const choice of ['state', 'error', 'sigma', 'time']) {
      await page.evaluate((trajectoryColor) => (window as any).rastro.app.set({ trajectoryColor }), choice);
    }
    await screenshot(page, 'damaged');
  });
});

test('parts without content and poses without numbers are no fault', () => withPage(pageWith('hollow.html', [{ name: 'hollow', bytes: hollowScene() }]), {}, async (page) => {
  await drawn(page);
  assert.match(await page.locator('aside').innerText(), /This map has no points/);
  await page.keyboard.press('a');
  await page.keyboard.press('c');
  await drawn(page);
}));

test('an empty map and a page without a map say so', async () => {
  const empty = pageWith('empty.html', [{ name: 'empty', bytes: new SceneWriter().finish({ state_names: stateNames }) }]);
  await withPage(empty, {}, async (page) => {
    assert.match(await page.getByRole('status').first().innerText(), /empty is empty: it has no trajectory, no keyframes and no points/);
    assert.match(await page.locator('aside').innerText(), /This map has no points/);
    assert.match(await page.locator('footer').innerText(), /no trajectory, so there is no timeline/);
    await screenshot(page, 'empty');
  });
  await withPage(pageWith('none.html', []), {}, async (page) => {
    assert.match(await page.getByRole('status').innerText(), /There is no map in this page/);
  });
});

test('scenes come from the server with the token of the address', async () => {
  const served = await serve([{ name: 'exact', bytes: exactScene() }], 'se cret&1');
  try {
    await withPage(`${served.url}?token=se%20cret%261`, {}, async (page) => {
      await drawn(page);
      assert.equal(await page.locator('h1').innerText(), 'exact');
    });
    const refused = await open(browser, served.url);
    assert.match(await refused.getByText('refused the token').innerText(), /open the address that rastro view printed/);
    await refused.close();
  } finally {
    served.close();
  }
});

test('the picture is saved as PNG, help and theme answer to keys', () => withPage(urls.room, {}, async (page) => {
  await drawn(page);
  const [download] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('s')]);
  assert.equal(download.suggestedFilename(), 'room.png');
  const file = readFileSync(await download.path());
  assert.ok(file.length > 10000 && file.toString('latin1', 1, 4) === 'PNG');
  await page.keyboard.press('?');
  assert.ok(await page.getByRole('dialog').isVisible());
  await screenshot(page, 'help');
  await page.keyboard.press('Escape');
  await page.keyboard.press('t');
  assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), 'light');
}));
