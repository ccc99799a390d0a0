// SPDX-License-Identifier: Apache-2.0
// Which tiles of an octree of points a view needs: the coarse ones first, finer ones where one could tell the difference.
import * as THREE from 'three';
import type { TileIndex } from '../scene/scene';

export interface TileView {
  eye: THREE.Vector3;
  frustum: THREE.Frustum;
  /** Pixels that one unit takes at a distance of one. */
  focalPx: number;
  /** Points whose neighbors are nearer on the screen are fine enough. */
  enoughPx: number;
  /** Points in one picture. */
  mostPoints: number;
}

export function viewOf(camera: THREE.PerspectiveCamera, heightPx: number, enoughPx: number, mostPoints: number): TileView {
  camera.updateMatrixWorld();
  const matrix = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  return {
    eye: camera.position, frustum: new THREE.Frustum().setFromProjectionMatrix(matrix),
    focalPx: heightPx / (2 * Math.tan(THREE.MathUtils.degToRad(camera.fov / 2))), enoughPx, mostPoints,
  };
}

export function childrenOf(index: TileIndex): number[][] {
  const children: number[][] = Array.from(index.parents, () => []);
  index.parents.forEach((parent, row) => parent >= 0 && children[parent].push(row));
  return children;
}

/** Rows beside the root, the most important first; a parent comes before its children. */
export function chooseTiles(index: TileIndex, children: number[][], view: TileView): number[] {
  const found: { row: number; gap: number }[] = [];
  const look = (row: number, gap: number) => {
    if (row > 0) found.push({ row, gap });
    for (const child of children[row]) {
      // What is missing without the child: gaps as wide as its parent's points are apart, seen where the child begins.
      const seen = Math.min(gap, (index.spacings[row] * view.focalPx) / distanceTo(index, child, view.eye));
      if (seen > view.enoughPx && view.frustum.intersectsBox(boxOf(index, child))) look(child, seen);
    }
  };
  if (index.parents.length > 0) look(0, Infinity);
  found.sort((a, b) => b.gap - a.gap);
  let points = index.counts[0] ?? 0;
  const end = found.findIndex(({ row }) => (points += index.counts[row]) > view.mostPoints);
  return (end < 0 ? found : found.slice(0, end)).map(({ row }) => row);
}

function boxOf(index: TileIndex, row: number): THREE.Box3 {
  const [x, y, z, half] = index.cubes.subarray(4 * row, 4 * row + 4);
  return new THREE.Box3(new THREE.Vector3(x - half, y - half, z - half), new THREE.Vector3(x + half, y + half, z + half));
}

/** Never 0: inside a tile one sees its points from somewhere. */
function distanceTo(index: TileIndex, row: number, eye: THREE.Vector3): number {
  return Math.max(boxOf(index, row).distanceToPoint(eye), 0.25 * index.cubes[4 * row + 3], 1e-9);
}
