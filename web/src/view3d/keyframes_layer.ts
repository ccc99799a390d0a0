// SPDX-License-Identifier: Apache-2.0
// Keyframes as small cameras (pyramids of the camera's own field of view), or as arrows for a laser.
import * as THREE from 'three';
import type { Camera, Keyframes, Vec3 } from '../scene/scene';
import { thinLines } from './materials';
import { count, type LayerObject, type Style } from './style';

/** Corner points of a drawn camera with depth 1, in camera axes; the first is the center. */
export function cameraShape(camera: Camera | null): Vec3[] {
  // A laser looks along x in its plane; the arrow points there.
  if (!camera) return [[-0.35, 0, 0], [-0.5, 0.4, 0], [0.7, 0, 0], [-0.5, -0.4, 0]];
  const x = [(0 - camera.cx) / camera.fx, (camera.width - camera.cx) / camera.fx];
  const y = [(0 - camera.cy) / camera.fy, (camera.height - camera.cy) / camera.fy];
  const corners: Vec3[] = [[0, 0, 0], [x[0], y[0], 1], [x[1], y[0], 1], [x[1], y[1], 1], [x[0], y[1], 1]];
  // The mark above the upper edge shows which side of the image is up.
  const middle = (x[0] + x[1]) / 2;
  return [...corners, [middle - 0.12, y[0] - 0.05, 1], [middle, y[0] - 0.22, 1], [middle + 0.12, y[0] - 0.05, 1]];
}

export function cameraLines(camera: Camera | null): [number, number][] {
  if (!camera) return [[0, 1], [1, 2], [2, 3], [3, 0]];
  return [[0, 1], [0, 2], [0, 3], [0, 4], [1, 2], [2, 3], [3, 4], [4, 1], [5, 6], [6, 7], [7, 5]];
}

export class KeyframesLayer implements LayerObject {
  readonly key = 'keyframes';
  readonly label = 'Keyframes';
  readonly detail: string;
  readonly object: THREE.LineSegments<THREE.BufferGeometry, THREE.LineBasicMaterial>;
  readonly shownAtFirst = true;
  private size = 0;

  constructor(private readonly keyframes: Keyframes, private readonly camera: Camera | null, runColor: string) {
    this.detail = count(keyframes.count, 'keyframe');
    const vertices = 2 * cameraLines(camera).length * keyframes.count;
    this.object = thinLines(new Float32Array(3 * vertices), runColor);
  }

  applyStyle(style: Style): void {
    if (style.cameraSize === this.size) return;
    this.size = style.cameraSize;
    const attribute = this.object.geometry.getAttribute('position') as THREE.BufferAttribute;
    const shape = cameraShape(this.camera).map((p) => new THREE.Vector3(...p).multiplyScalar(this.size));
    const lines = cameraLines(this.camera);
    const corner = new THREE.Vector3();
    for (let row = 0, vertex = 0; row < this.keyframes.count; row++) {
      const pose = poseOf(this.keyframes.poses, row);
      for (const ends of lines) {
        for (const end of ends) {
          corner.copy(shape[end]).applyQuaternion(pose.orientation).add(pose.position);
          attribute.setXYZ(vertex++, corner.x, corner.y, corner.z);
        }
      }
    }
    attribute.needsUpdate = true;
  }
}

export interface Pose {
  position: THREE.Vector3;
  orientation: THREE.Quaternion;
}

/** Pose of a row of seven numbers (x y z qx qy qz qw). */
export function poseOf(poses: Float32Array, row: number): Pose {
  const p = poses.subarray(7 * row, 7 * row + 7);
  return {
    position: new THREE.Vector3(p[0], p[1], p[2]),
    orientation: new THREE.Quaternion(p[3], p[4], p[5], p[6]).normalize(),
  };
}
