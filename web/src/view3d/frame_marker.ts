// SPDX-License-Identifier: Apache-2.0
// The current frame in the view: a thick camera with a yellow dot at its center, never hidden by points.
import * as THREE from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import type { Camera, Frames } from '../scene/scene';
import { cameraLines, cameraShape } from './keyframes_layer';
import { dots } from './materials';
import { okabeIto } from './colors';

export class FrameMarker {
  readonly object = new THREE.Group();
  private readonly lines: LineSegments2;
  private readonly material = new LineMaterial({ linewidth: 3, depthTest: false });

  constructor(camera: Camera | null) {
    const geometry = new LineSegmentsGeometry();
    const shape = cameraShape(camera);
    geometry.setPositions(cameraLines(camera).flatMap(([a, b]) => [...shape[a], ...shape[b]]));
    this.lines = new LineSegments2(geometry, this.material);
    this.lines.frustumCulled = false;
    this.object.add(this.lines, dots([[0, 0, 0]], okabeIto.yellow, 11));
    this.object.renderOrder = 10;
    for (const child of this.object.children) child.renderOrder = 10;
  }

  /** Gives back what the graphics card holds for it. */
  dispose(): void {
    for (const child of this.object.children as (LineSegments2 | THREE.Points)[]) {
      child.geometry.dispose();
      (child.material as THREE.Material).dispose();
    }
  }

  /** False where the frame has no finite pose. */
  place(frames: Frames, row: number, size: number, dark: boolean): boolean {
    const p = frames.positions.subarray(3 * row, 3 * row + 3);
    const q = frames.orientations.subarray(4 * row, 4 * row + 4);
    const known = [...p, ...q].every(Number.isFinite);
    this.object.visible = known;
    if (!known) return false;
    this.object.position.set(p[0], p[1], p[2]);
    this.object.quaternion.set(q[0], q[1], q[2], q[3]).normalize();
    this.lines.scale.setScalar(1.8 * size);
    this.material.color.set(dark ? '#ffffff' : '#000000');
    return true;
  }
}
