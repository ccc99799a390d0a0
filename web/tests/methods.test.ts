// SPDX-License-Identifier: Apache-2.0
// The map of each method, from a generated world: every layer changes the picture, and its points are drawn where the map
// says. Needs the program and takes minutes: only where RASTRO_PROGRAM names it.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { before, test } from 'node:test';
import type { Page } from 'playwright-core';
import { drawn, pageWith, readPng, screenshot, type Picture } from './browser';
import { canvasPicture, colors, useBrowser, withPage } from './page_testing';
import { rastro, scratchFolder, skip } from './program_testing';

const folder = scratchFolder('methods');

useBrowser();

before(() => {
  if (skip) return;
  rastro(folder, 'simulate', 'hall', '--out', 'hall', '--frames', '90', '--no-ground-truth', '--quiet');
  rastro(folder, 'simulate', 'study', '--out', 'study', '--frames', '180', '--every', '2', '--quiet');
  rastro(folder, 'simulate', 'corridor', '--out', 'corridor', '--frames', '400', '--quiet');
});

interface Case {
  command: 'slam' | 'odometry';
  world: string;
  /** Layers that the map of this method must have. */
  layers: string[];
  /** Further flags of the export. */
  flags?: string[];
}

const cases: Record<string, Case> = {
  rgbd: { command: 'slam', world: 'study', layers: ['trajectory:final', 'keyframes', 'points:cloud', 'edges:odometry', 'mesh:mesh', 'cubes:octree'], flags: ['--mesh', '--octree'] },
  rtabmap: { command: 'slam', world: 'study', layers: ['trajectory:final', 'keyframes', 'points:cloud'] },
  orb: { command: 'slam', world: 'hall', layers: ['trajectory:final', 'keyframes', 'points:landmarks', 'edges:covisibility', 'edges:spanning_tree', 'ellipsoids:landmark_covariances'] },
  lsd: { command: 'slam', world: 'hall', layers: ['trajectory:final', 'keyframes', 'points:semi_dense'] },
  hector: { command: 'slam', world: 'corridor', layers: ['trajectory:final', 'keyframes', 'points:scans', 'grid:grid'] },
  ekf: { command: 'slam', world: 'corridor', layers: ['trajectory:final', 'keyframes', 'points:landmarks', 'grid:grid'] },
  fusion: { command: 'slam', world: 'study', layers: ['trajectory:final', 'keyframes', 'points:landmarks'] },
  features: { command: 'odometry', world: 'hall', layers: ['trajectory:final', 'trajectory:online'] },
  hybrid: { command: 'odometry', world: 'hall', layers: ['trajectory:final'] },
  classic: { command: 'odometry', world: 'hall', layers: ['trajectory:final'] },
  profiles: { command: 'odometry', world: 'hall', layers: ['trajectory:final'] },
};

for (const [method, { command, world, layers, flags }] of Object.entries(cases)) {
  test(`the run of ${method} is shown: each layer, and its points where the map says`, { skip }, async () => {
    rastro(folder, command, world, '--method', method, '--out', `run_${method}`, '--quiet');
    rastro(folder, 'export', `run_${method}`, '--to', 'html', ...(command === 'slam' ? ['--points', '20000'] : []), ...(flags ?? []), '--out', `${method}.html`, '--quiet');
    await withPage(inCurrentPage(`${folder}/${method}.html`, method), {}, async (page) => {
      await drawn(page);
      const picture = await screenshot(page, `method_${method}`);
      assert.ok(colors(picture, 280, 50, picture.width - 280, 640).size > 8, 'blank');
      const keys = await page.$$eval('[data-layer]', (boxes) => boxes.map((b) => (b as HTMLElement).dataset.layer!));
      for (const layer of layers) assert.ok(keys.includes(layer), `${layer} is missing in ${keys}`);
      for (const key of keys) await switchesThePicture(page, key);
      for (const key of keys) await pointsLieWhereTheMapSays(page, key);
    });
    for (const [width, height, dark] of [[390, 844, false], [390, 844, true], [1280, 800, false]] as const) {
      await withPage(inCurrentPage(`${folder}/${method}.html`, method), { width, height, dark }, async (page) => {
        await drawn(page);
        const shot = await screenshot(page, `method_${method}_${dark ? 'dark' : 'light'}_${width}`);
        assert.ok(colors(shot, 20, 120, Math.min(width, 1000), 640).size > 8, 'blank');
        assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width);
      });
    }
  });
}

/** The exported scene in the page as it is built now, not as it was packed into the program. */
function inCurrentPage(file: string, method: string): string {
  const [, base64] = /class="rastro-scene"[^>]*>([^<]*)</.exec(readFileSync(file, 'latin1'))!;
  return pageWith(`method_${method}.html`, [{ name: method, bytes: Buffer.from(base64, 'base64') }]);
}

async function switchesThePicture(page: Page, key: string): Promise<void> {
  // What lies below others alone might be hidden.
  await only(page, key);
  const on = await canvasPicture(page);
  await page.evaluate((k) => (window as any).rastro.app.setLayer(k, false), key);
  assert.notEqual(await canvasPicture(page), on, `${key} is not seen`);
}

/** The 3D view alone, without the mark of the current frame. */
async function bare(page: Page): Promise<Picture> {
  const data = await page.evaluate(() => {
    const { view } = (window as any).rastro.app;
    view.marks.visible = false;
    view.drawAll();
    return view.canvas.toDataURL('image/png').split(',')[1] as string;
  });
  return readPng(Buffer.from(data, 'base64'));
}

async function only(page: Page, key: string): Promise<void> {
  await page.evaluate((k) => {
    const { app } = (window as any).rastro;
    const keys = ['reference', ...app.runs.flatMap((r: any) => r.layers.map((l: any) => l.key))];
    app.set({ layers: Object.fromEntries(keys.map((each) => [each, each === k])), frame: 0 });
  }, key);
}

/** Where points of the layer are, it is drawn; where none is near, there is nothing. */
async function pointsLieWhereTheMapSays(page: Page, key: string): Promise<void> {
  if (!/^(points|keyframes|grid|cubes)/.test(key)) return;
  await only(page, key);
  await drawn(page);
  const places = await page.evaluate((k) => {
    const { app, project } = (window as any).rastro;
    const box = app.view.canvas.getBoundingClientRect();
    const { scene, layers } = app.runs[0];
    const layer = scene.layers[layers.findIndex((l: any) => l.key === k) - (layers.length - scene.layers.length)];
    const values: ArrayLike<number> = k === 'keyframes' ? scene.keyframes.poses : layer.positions ?? layer.centers ?? occupied(layer);
    const stride = k === 'keyframes' ? 7 : 3;
    const found: [number, number][] = [];
    for (let i = 0; i + 2 < values.length; i += stride) {
      const p = project([values[i], values[i + 1], values[i + 2]]);
      if (p && p[0] > box.left + 4 && p[0] < box.right - 4 && p[1] > box.top + 4 && p[1] < box.bottom - 4) found.push([p[0] - box.left, p[1] - box.top]);
    }
    return found;
    function occupied(grid: any): number[] {
      return [...grid.cells].flatMap((cell: number, i: number) => (cell === 254 || (cell >= 200 && cell < 255)
        ? [grid.origin[0] + ((i % grid.width) + 0.5) * grid.cell, grid.origin[1] + (Math.floor(i / grid.width) + 0.5) * grid.cell, 0] : []));
    }
  }, key);
  assert.ok(places.length > 0, `${key} is out of sight`);
  const picture = await bare(page);
  const back = [20, 24, 29];
  // A camera's tip is its position, a laser's mark stands around it.
  const reach = key === 'keyframes' ? 10 : 2;
  const isDrawn = (x: number, y: number) => {
    for (let dx = -reach; dx <= reach; dx++) for (let dy = -reach; dy <= reach; dy++) {
      const [px, py] = [Math.round(x) + dx, Math.round(y) + dy];
      if (px < 0 || py < 0 || px >= picture.width || py >= picture.height) continue;
      if (picture.at(px, py).some((v, c) => Math.abs(v - back[c]) > 4)) return true;
    }
    return false;
  };
  const step = Math.ceil(places.length / 200);
  const sample = places.filter((_, i) => i % step === 0);
  const seen = sample.filter(([x, y]) => isDrawn(x, y)).length;
  assert.ok(seen >= 0.97 * sample.length, `${key}: ${seen} of ${sample.length} points are drawn`);
  if (!key.startsWith('points')) return;
  let [empty, wrong] = [0, 0];
  for (let x = 4; x < picture.width - 4; x += 23) for (let y = 4; y < picture.height - 4; y += 23) {
    if (places.some((p) => Math.abs(p[0] - x) < 12 && Math.abs(p[1] - y) < 12)) continue;
    empty++;
    if (isDrawn(x, y)) wrong++;
  }
  assert.ok(wrong <= 0.03 * empty, `${key}: something is drawn at ${wrong} of ${empty} places without points`);
}
