// SPDX-License-Identifier: Apache-2.0
// Edges between keyframes: covisibility, spanning tree, odometry, loops.
import type * as THREE from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import type { EdgesLayer as EdgesData, Keyframes } from '../scene/scene';
import { loopColor } from './colors';
import { drawable, thinLines } from './materials';
import { count, titled, type LayerObject, type Style } from './style';

/** Few loops are what people look for and are drawn thick; thousands would cover the map and are drawn faint. */
const fewLoops = 300;
const isLoops = (name: string) => name.includes('loop');

export class EdgesLayer implements LayerObject {
  readonly key: string;
  readonly label: string;
  readonly detail: string;
  readonly object: THREE.Object3D;
  readonly shownAtFirst: boolean;
  private readonly thin: THREE.LineBasicMaterial | null = null;

  constructor(data: EdgesData, keyframes: Keyframes | null) {
    this.key = `edges:${data.name}`;
    this.label = titled(data.name);
    this.detail = data.count === 0 ? 'none' : count(data.count, 'edge');
    this.shownAtFirst = isLoops(data.name) || data.name === 'spanning_tree' || data.name === 'odometry';
    const positions = ends(data, keyframes);
    if (isLoops(data.name) && positions.length > 0 && data.count <= fewLoops) {
      this.object = thickLines(positions);
    } else {
      const loops = isLoops(data.name);
      const lines = thinLines(positions, loopColor, loops ? faint(data.count) : 0.5);
      lines.renderOrder = -1; // below trajectory and points
      if (!loops) this.thin = lines.material;
      this.object = lines;
    }
  }

  applyStyle(style: Style): void {
    this.thin?.color.set(style.dark ? '#9fb4c8' : '#44566a');
  }
}

function faint(count: number): number {
  return Math.max(0.06, 0.8 * Math.sqrt(fewLoops / Math.max(count, fewLoops)));
}

function thickLines(positions: Float32Array): THREE.Object3D {
  const geometry = new LineSegmentsGeometry();
  geometry.setPositions(positions);
  const lines = new LineSegments2(geometry, new LineMaterial({ linewidth: 2, color: loopColor }));
  lines.frustumCulled = false;
  return lines;
}

function ends(data: EdgesData, keyframes: Keyframes | null): Float32Array {
  const positions = new Float32Array(3 * data.pairs.length);
  let used = 0;
  for (let i = 0; i < data.pairs.length; i += 2) {
    const [a, b] = [7 * data.pairs[i], 7 * data.pairs[i + 1]];
    const { poses } = keyframes!;
    if (!drawable(poses, a) || !drawable(poses, b)) continue;
    positions.set(poses.subarray(a, a + 3), used);
    positions.set(poses.subarray(b, b + 3), used + 3);
    used += 6;
  }
  return positions.subarray(0, used);
}
