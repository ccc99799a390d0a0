// SPDX-License-Identifier: Apache-2.0
// Reference grid at the lowest height of the content, with the axes of the world: x red-orange, y green, z blue.
import * as THREE from 'three';
import type { Vec3 } from '../scene/scene';
import { okabeIto } from './colors';
import { thinLines } from './materials';
import type { Style } from './style';
import { horizontal } from './viewpoint';

/** 1, 2 or 5 times a power of ten, the next one above `value`. */
export function niceStep(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  return (value / power <= 1 ? 1 : value / power <= 2 ? 2 : value / power <= 5 ? 5 : 10) * power;
}

export class Reference {
  readonly object = new THREE.Group();
  readonly cell: number;
  private readonly grid: THREE.LineSegments<THREE.BufferGeometry, THREE.LineBasicMaterial>;

  constructor(bounds: THREE.Box3, outline: THREE.Vector3[], up: Vec3) {
    const size = bounds.getSize(new THREE.Vector3()).length();
    this.cell = niceStep(size / 15);
    this.grid = thinLines(gridLines(outline, new THREE.Vector3(...up), this.cell), '#888888', 0.3);
    this.grid.material.depthWrite = false;
    this.grid.renderOrder = -2;
    this.object.add(this.grid);
    [okabeIto.vermillion, okabeIto.green, okabeIto.blue].forEach((color, axis) => {
      const line = new Float32Array(6);
      line[3 + axis] = this.cell;
      this.object.add(thinLines(line, color));
    });
  }

  dispose(): void {
    for (const child of this.object.children as THREE.LineSegments<THREE.BufferGeometry, THREE.Material>[]) {
      child.geometry.dispose();
      child.material.dispose();
    }
  }

  applyStyle(style: Style): void {
    this.grid.material.color.set(style.dark ? '#53606d' : '#a9b3bd');
  }
}

function gridLines(outline: THREE.Vector3[], up: THREE.Vector3, cell: number): Float32Array {
  const [right, ahead] = horizontal(up);
  const extent = (axis: THREE.Vector3) => {
    const values = outline.map((p) => p.dot(axis));
    return [Math.floor(Math.min(...values) / cell) - 1, Math.ceil(Math.max(...values) / cell) + 1];
  };
  const [a0, a1] = extent(right);
  const [b0, b1] = extent(ahead);
  // The lowest points of all are often wrong ones.
  const heights = outline.map((p) => p.dot(up)).sort((a, b) => a - b);
  const lowest = heights[Math.floor(0.005 * heights.length)];
  const at = (a: number, b: number) => new THREE.Vector3()
    .addScaledVector(right, a * cell).addScaledVector(ahead, b * cell).addScaledVector(up, lowest);
  const points: THREE.Vector3[] = [];
  for (let a = a0; a <= a1; a++) points.push(at(a, b0), at(a, b1));
  for (let b = b0; b <= b1; b++) points.push(at(a0, b), at(a1, b));
  return Float32Array.from(points.flatMap((p) => p.toArray()));
}
