// SPDX-License-Identifier: Apache-2.0
// Reads one layer of a scene.
import { checkIndices, type Entry } from './header';
import type {
  CubesLayer,
  EdgesLayer,
  EllipsoidsLayer,
  GridLayer,
  Layer,
  MeshLayer,
  PointsLayer,
  TileIndex,
} from './scene';

export function parseLayer(entry: Entry, keyframes: number): Layer {
  const kind = entry.text('kind');
  switch (kind) {
    case 'edges':
      return parseEdges(entry, keyframes);
    case 'points':
      return parsePoints(entry, keyframes);
    case 'mesh':
      return parseMesh(entry);
    case 'cubes':
      return parseCubes(entry);
    case 'grid':
      return parseGrid(entry);
    case 'ellipsoids':
      return parseEllipsoids(entry);
    default:
      throw entry.error('kind', `is ${kind.slice(0, 40)}, which this page does not know`);
  }
}

function parseEdges(entry: Entry, keyframes: number): EdgesLayer {
  const pairs = entry.array('pairs', 'u32', 2, null);
  checkIndices(pairs, keyframes, `${entry.where}.pairs`);
  return { kind: 'edges', name: entry.text('name'), count: pairs.length / 2, pairs };
}

function parsePoints(entry: Entry, keyframes: number): PointsLayer {
  const tiles = entry.child('tiles');
  return { kind: 'points', name: entry.text('name'), ...parsePointArrays(entry, keyframes), tiles: tiles && parseTiles(tiles) };
}

/** What a layer and a tile of one have in common. */
export function parsePointArrays(entry: Entry, keyframes: number): Omit<PointsLayer, 'kind' | 'name' | 'tiles'> {
  const positions = entry.array('positions', 'f32', 3, null);
  const count = positions.length / 3;
  const rows = entry.arrayOrNull('keyframes', 'u32', 1, count);
  if (rows) checkIndices(rows, keyframes, entry.where === '' ? 'keyframes' : `${entry.where}.keyframes`);
  return { count, positions, colors: entry.arrayOrNull('colors', 'u8', 3, count), sigmas: entry.arrayOrNull('sigmas', 'f32', 1, count), keyframes: rows };
}

/** Parents come before their children, so that no path in the tree goes around. */
function parseTiles(entry: Entry): TileIndex {
  const parents = entry.array('parents', 'i32', 1, null);
  const rows = parents.length;
  parents.forEach((parent, row) => {
    if (row === 0 ? parent !== -1 : parent < 0 || parent >= row) throw entry.error('parents', `has ${parent} at ${row}`);
  });
  return {
    parents, count: entry.index('count', 2 ** 40), layer: entry.index('layer', 2 ** 31), url: null,
    cubes: entry.array('cubes', 'f32', 4, rows), spacings: entry.array('spacings', 'f32', 1, rows), counts: entry.array('counts', 'u32', 1, rows),
  };
}

function parseMesh(entry: Entry): MeshLayer {
  const positions = entry.array('positions', 'f32', 3, null);
  const vertices = positions.length / 3;
  const triangles = entry.array('triangles', 'u32', 3, null);
  checkIndices(triangles, vertices, `${entry.where}.triangles`);
  const colors = entry.arrayOrNull('colors', 'u8', 3, vertices);
  return { kind: 'mesh', name: entry.text('name'), count: triangles.length / 3, positions, colors, triangles };
}

function parseCubes(entry: Entry): CubesLayer {
  const centers = entry.array('centers', 'f32', 3, null);
  const count = centers.length / 3;
  const sizes = entry.array('sizes', 'f32', 1, count);
  return { kind: 'cubes', name: entry.text('name'), count, centers, sizes, colors: entry.arrayOrNull('colors', 'u8', 3, count) };
}

function parseGrid(entry: Entry): GridLayer {
  // A texture has at most 16384 cells a side on common graphics cards.
  const width = entry.index('width', 16385);
  const height = entry.index('height', 16385);
  const cells = entry.array('cells', 'u8', 1, width * height);
  const origin = entry.numbers('origin', 2) as [number, number];
  return { kind: 'grid', name: entry.text('name'), count: cells.length, width, height, cell: entry.positive('cell'), origin, cells };
}

function parseEllipsoids(entry: Entry): EllipsoidsLayer {
  const centers = entry.array('centers', 'f32', 3, null);
  const count = centers.length / 3;
  return { kind: 'ellipsoids', name: entry.text('name'), count, centers, axes: entry.array('axes', 'f32', 9, count) };
}
