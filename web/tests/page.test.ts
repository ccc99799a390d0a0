// SPDX-License-Identifier: Apache-2.0
// The built page in a browser: what is drawn, and where; scenes that are damaged, empty, or served.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drawn, open, pageWith, screenshot } from './browser';
import { damaged } from './damage';
import { canvasPicture, colors, near, pixelAt, project, sharedBrowser, urls, useBrowser, withPage } from './page_testing';
import { SceneWriter, random } from './scene_writer';
import { exactScene, floorScene, hollowScene, roomScene, stateNames } from './scenes';
import { serve } from './serve';

useBrowser();

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

test('nothing is drawn while nothing changes', () => withPage(urls.room, {}, async (page) => {
  await drawn(page);
  const pictures = () => page.evaluate(() => (window as any).rastro.stats.pictures);
  const before = await pictures();
  await page.evaluate(async () => {
    for (let i = 0; i < 20; i++) await new Promise((done) => requestAnimationFrame(done));
  });
  assert.equal(await pictures(), before);
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
    const refused = await open(sharedBrowser(), served.url);
    assert.match(await refused.getByText('refused the token').innerText(), /open the address that rastro view printed/);
    await refused.close();
  } finally {
    served.close();
  }
});
