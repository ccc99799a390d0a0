// SPDX-License-Identifier: Apache-2.0
// The built page in a browser: timeline, measuring, address, keys, narrow screens.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { drawn, pageWith, screenshot } from './browser';
import { clickPoint, near, pixelAt, project, sharedBrowser, urls, useBrowser, withPage } from './page_testing';
import { imagesScene, roomScene } from './scenes';

useBrowser();

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

test('edges and faces of the table are measured, and drawn as long as they are', () => withPage(urls.shelf, {}, async (page) => {
  await drawn(page);
  await page.keyboard.press('m');
  await page.keyboard.press('x');
  assert.match(await page.locator('.hint').innerText(), /Click a point near an edge/);
  for (const p of [[0, 0.15, 0], [0.75, 0.15, 0]]) await clickPoint(page, p);
  const [, length, sigma] = /([\d.]+) ± ([\d.]+) m/.exec(await page.locator('.lengths .value').innerText())!.map(Number);
  assert.ok(Math.abs(length - 0.75) < sigma && sigma < 0.03, `${length} ± ${sigma}`);
  await page.getByRole('button', { name: 'face' }).click();
  for (const p of [[0.4, 0.15, 0], [0.4, -0.3, 0.4]]) await clickPoint(page, p);
  const [, depth, error] = /([\d.]+) ± ([\d.]+) m/.exec(await page.locator('.lengths .value').nth(1).innerText())!.map(Number);
  assert.ok(Math.abs(depth - 0.4) < error && error < 0.01, `${depth} ± ${error}`);
  assert.match(await page.locator('.lengths').innerText(), /from the points of the map/);
  await clickPoint(page, [0.4, 0.15, 0]);
  await page.keyboard.press('x');
  await page.keyboard.press('x');
  await clickPoint(page, [0, 0.15, 0]);
  assert.match(await page.locator('.hint').innerText(), /Measured|not parallel/);
  await screenshot(page, 'measured_edges');
}));

test('a video of one turn is saved, and the view is where it was', () => withPage(urls.exact, {}, async (page) => {
  await drawn(page);
  const before = await project(page, [1, 2, 0]);
  await page.keyboard.press('b');
  await screenshot(page, 'video');
  await page.getByRole('button', { name: /One turn/ }).click();
  await page.waitForFunction((p) => Math.abs((window as any).rastro.project([1, 2, 0])[0] - p) > 30, before[0]);
  const [download] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('b')]);
  assert.match(download.suggestedFilename(), /^exact\.(mp4|webm)$/);
  const file = readFileSync(await download.path());
  assert.ok(file.length > 2000 && (file.readUInt32BE(0) === 0x1a45dfa3 || file.toString('latin1', 4, 8) === 'ftyp'));
  near(await project(page, [1, 2, 0]), before, 0.01);
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
  await page.getByRole('button', { name: 'Remove' }).first().click();
  assert.deepEqual(await page.locator('.lengths .value').allInnerTexts(), ['2.000 ± 0.011 units']);
  assert.match(await page.locator('[data-layer="reference"]').innerText(), /cell [\d.]+ units?/);
}));

test('the largest value beside the curve has the scale of the run', () => withPage(urls.room, {}, async (page) => {
  await drawn(page);
  const written = await page.evaluate(() => {
    const { app } = (window as any).rastro;
    const texts: string[] = [];
    const { fillText } = CanvasRenderingContext2D.prototype;
    CanvasRenderingContext2D.prototype.fillText = function (text: string, ...place: [number, number]) {
      texts.push(text);
      fillText.call(this, text, ...place);
    };
    const largest = () => {
      texts.length = 0;
      app.refresh();
      return parseFloat(texts.at(-1)!.match(/ m$/) ? texts.at(-1)! : texts.find((t) => / m$/.test(t))!);
    };
    const before = largest();
    app.scaleFactors.set(0, { factor: 2, sigma: 0 });
    return [before, largest()];
  });
  near([written[1]], [2 * written[0]], 0.02 * written[0]);
}));

test('the theme button leads to the other theme, also after that of the system changed', () => withPage(urls.exact, { dark: true }, async (page) => {
  const theme = () => page.evaluate(() => document.documentElement.dataset.theme);
  await drawn(page);
  await page.emulateMedia({ colorScheme: 'light' });
  await page.waitForFunction(() => document.documentElement.dataset.theme === 'light');
  await page.getByRole('button', { name: 'Theme' }).click();
  assert.equal(await theme(), 'dark');
  await page.getByRole('button', { name: 'Theme' }).click();
  assert.equal(await theme(), 'light');
}));

test('the mark of the current frame gives back what it held when another run becomes active', async () => {
  const url = pageWith('two.html', [{ name: 'room', bytes: roomScene({ points: 100 }) }, { name: 'images', bytes: imagesScene([]) }]);
  await withPage(url, {}, async (page) => {
    await drawn(page);
    const held = async (times: number) => {
      for (let i = 0; i < times; i++) {
        await page.evaluate(() => (window as any).rastro.app.set({ active: 1 - (window as any).rastro.app.state.active }));
        await drawn(page);
      }
      return page.evaluate(() => (window as any).rastro.app.view.renderer.info.memory.geometries as number);
    };
    const before = await held(2);
    assert.equal(await held(6), before);
  });
});

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
    location.hash = '#run=7&frame=200&layers=-keyframes&view=0,-9,0.01,0,0,0';
  });
  await page.waitForFunction(() => (window as any).rastro.app.state.frame === 200);
  assert.equal(await page.evaluate(() => (window as any).rastro.app.state.active), 0, 'there is no run 7');
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
  const maker = await sharedBrowser().newPage();
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
