// SPDX-License-Identifier: Apache-2.0
// Layers of many points in tiles: which ones a view needs, that they are fetched then and drawn where they lie.
import assert from 'node:assert/strict';
import { afterEach, test } from 'node:test';
import type { Page } from 'playwright-core';
import * as THREE from 'three';
import { parseScene } from '../src/scene/parse';
import { SceneError, type PointsLayer, type TileIndex } from '../src/scene/scene';
import { childrenOf, chooseTiles, viewOf } from '../src/view3d/tile_choice';
import { readTile } from '../src/view3d/tile_loader';
import { drawn, faultsOf, open } from './browser';
import { damaged } from './damage';
import { until, wait } from './live_testing';
import { near, pixelAt, sharedBrowser, useBrowser } from './page_testing';
import { SceneWriter, random } from './scene_writer';
import { serve } from './serve';

useBrowser();
const closing: (() => unknown)[] = [];
afterEach(async () => {
  for (const close of closing.splice(0)) await close();
});

/** A root over 16 m with gray points 5 cm apart at most, two of its octants with finer points, one of these with finer ones still. */
const tree = {
  cubes: [[0, 0, 0, 8], [-4, -4, -4, 4], [4, 4, 4, 4], [-2, -2, -2, 2]], spacings: [0.05, 0.025, 0, 0], parents: [-1, 0, 0, 1], counts: [2000, 961, 961, 100],
};

function index(): TileIndex {
  const { cubes, spacings, parents, counts } = tree;
  return {
    count: 4022, layer: 0, url: null, cubes: Float32Array.from(cubes.flat()), spacings: Float32Array.from(spacings),
    parents: Int32Array.from(parents), counts: Uint32Array.from(counts),
  };
}

function chosen(eye: [number, number, number], target: [number, number, number], mostPoints = 1e6): number[] {
  const camera = new THREE.PerspectiveCamera(40, 1.6, 0.01, 1000);
  camera.position.set(...eye);
  camera.lookAt(...target);
  return chooseTiles(index(), childrenOf(index()), viewOf(camera, 800, 1.5, mostPoints));
}

test('a view needs the tiles that it sees from near, the coarse ones first, as many as it may have', () => {
  assert.deepEqual(chosen([0, 0, 60], [0, 0, 0]), [], 'from afar the root is fine enough');
  assert.deepEqual(chosen([-4, -4, 6], [-4, -4, -4]), [1, 3]);
  assert.deepEqual(chosen([7, 7, 10], [7, 7, 4]), [2], 'the others are out of sight');
  assert.deepEqual(chosen([-4, -4, 6], [-4, -4, 16]), [], 'behind the eye');
  assert.deepEqual(chosen([-2, -2, -2], [-4, -4, -4], 2961), [1], 'no more points than asked for');
});

/** A square of points that faces z: 31 x 31 over 2 m, or 10 x 10 over 1 m. */
function square(center: number[], side: number, width: number): number[] {
  return Array.from({ length: side * side }, (_, i) => [((i % side) / (side - 1) - 0.5) * width, (Math.floor(i / side) / (side - 1) - 0.5) * width, 0].map((v, axis) => v + center[axis])).flat();
}

function pointArrays(w: SceneWriter, positions: number[], color: number[]): object {
  return { positions: w.f32(positions), colors: w.u8(positions.map((_, i) => color[i % 3])) };
}

function tile(row: number): Uint8Array {
  const w = new SceneWriter();
  const part = row === 1 ? pointArrays(w, square([-4, -4, -4], 31, 2), [255, 0, 0])
    : row === 2 ? pointArrays(w, square([4, 4, 4], 31, 2), [0, 0, 255]) : pointArrays(w, square([-2, -2, -2], 10, 1), [0, 255, 0]);
  return w.finish({ type: 'tile', ...part });
}

function scene(): Uint8Array {
  const w = new SceneWriter();
  const rnd = random(2);
  const root = pointArrays(w, Array.from({ length: 6000 }, () => 16 * rnd() - 8), [90, 90, 90]);
  const tiles = { layer: 0, count: 4022, cubes: w.f32(tree.cubes.flat()), spacings: w.f32(tree.spacings), parents: w.i32(tree.parents), counts: w.u32(tree.counts) };
  return w.finish({ title: 'tiles', up: [0, 1, 0], layers: [{ kind: 'points', name: 'cloud', ...root, tiles }] });
}

async function lookFrom(page: Page, eye: number[], target: number[]): Promise<void> {
  await page.evaluate(([e, t]) => {
    const { view } = (window as any).rastro.app;
    view.controls.target.set(...(t as [number, number, number]));
    view.camera.position.set(...(e as [number, number, number]));
    view.controls.update();
    view.requestDraw();
  }, [eye, target]);
  await until(async () => page.evaluate(() => (window as any).rastro.stats.pictures > 0), 'a picture');
  await drawn(page);
}

test('tiles are fetched when the view comes near, drawn where they lie, and can be measured', async () => {
  const asked: number[] = [];
  const served = await serve([{ name: 'tiles', bytes: scene(), tile: (row) => (asked.push(row), tile(row)) }], 'abc');
  const page = await open(sharedBrowser(), `${served.url}?token=abc#size=7&layers=-reference&view=0,0,60,0,0,0`, {});
  closing.push(() => page.close(), () => served.close());
  await drawn(page);
  assert.deepEqual(asked, [], 'from afar nothing is fetched');
  const look = (eye: number[], target: number[]) => lookFrom(page, eye, target);
  await look([-4, -4, 6], [-4, -4, -4]);
  await until(async () => asked.length === 2, 'both tiles');
  await drawn(page);
  near(await pixelAt(page, [-4, -4, -4], 'tiles_near'), [255, 0, 0]);
  assert.equal(await page.evaluate(() => (window as any).rastro.stats.pointsVisible), 2000 + 961 + 100);
  const sources = await page.evaluate(() => (window as any).rastro.app.runs[0].layers[0].shown.map((data: any) => data.count));
  assert.deepEqual(sources, [2000, 961, 100]);
  await look([4, 4, 14], [4, 4, 4]);
  await until(async () => asked.length === 3, 'the third tile');
  await drawn(page);
  near(await pixelAt(page, [4, 4, 4], 'tiles_other'), [0, 0, 255]);
  await look([-4, -4, 6], [-4, -4, -4]);
  near(await pixelAt(page, [-4, -4, -4], 'tiles_again'), [255, 0, 0]);
  assert.deepEqual(asked, [1, 3, 2], 'each is fetched once');
  assert.match(await page.locator('[data-layer="points:cloud"]').innerText(), /4,022 points/);
  assert.deepEqual(faultsOf(page), []);
});

test('a tile that did not come is asked for again when the view moves later, one that cannot be read is not', async () => {
  const asked: number[] = [];
  const answer = (row: number) => (row === 3 ? Uint8Array.of(1, 2, 3) : asked.filter((each) => each === row).length > 1 ? tile(row) : null);
  const served = await serve([{ name: 'tiles', bytes: scene(), tile: (row) => (asked.push(row), answer(row)) }], 'abc');
  const page = await open(sharedBrowser(), `${served.url}?token=abc#size=7&layers=-reference&view=0,0,60,0,0,0`, {});
  closing.push(() => page.close(), () => served.close());
  await drawn(page);
  await lookFrom(page, [-4, -4, 6], [-4, -4, -4]);
  await lookFrom(page, [-4, -4, 6.1], [-4, -4, -4]);
  assert.deepEqual(asked, [1, 3], 'not at once');
  await wait(2100);
  await lookFrom(page, [-4, -4, 6], [-4, -4, -4]);
  assert.deepEqual(asked, [1, 3, 1]);
  near(await pixelAt(page, [-4, -4, -4], 'tiles_came_later'), [255, 0, 0]);
});

test('a file that has an index of tiles shows its root', () => {
  const layer = parseScene(scene()).layers[0] as PointsLayer;
  assert.deepEqual([layer.count, layer.tiles!.count, layer.tiles!.url], [2000, 4022, null]);
});

test('5000 damaged tiles and 5000 damaged scenes with tiles give one, or a SceneError, never another fault', () => {
  const rnd = random(8);
  for (const [whole, read] of [[tile(1), (bytes: Uint8Array) => readTile(bytes, 961, 0)], [scene(), parseScene]] as [Uint8Array, (bytes: Uint8Array) => unknown][]) {
    const counts = { read: 0, refused: 0 };
    for (let i = 0; i < 5000; i++) {
      try {
        read(damaged(whole, rnd));
        counts.read++;
      } catch (error) {
        if (!(error instanceof SceneError)) throw error;
        counts.refused++;
      }
    }
    assert.ok(counts.read > 100 && counts.refused > 100, JSON.stringify(counts));
  }
});
