// SPDX-License-Identifier: Apache-2.0
// Geometry of where to look from.
import * as THREE from 'three';
import type { Vec3 } from '../scene/scene';

/** Two horizontal axes: right, and ahead (up in a view from above). x stays right wherever that is possible. */
export function horizontal(up: THREE.Vector3): [THREE.Vector3, THREE.Vector3] {
  const start = Math.abs(up.x) < 0.9 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
  const right = start.addScaledVector(up, -start.dot(up)).normalize();
  return [right, new THREE.Vector3().crossVectors(up, right)];
}

export function corners(box: THREE.Box3): THREE.Vector3[] {
  return Array.from({ length: 8 }, (_, i) => new THREE.Vector3(
    i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z,
  ));
}

/** Distance from the center, along `direction`, from which all points are in the picture. */
export function fitDistance(points: THREE.Vector3[], center: THREE.Vector3, direction: THREE.Vector3, camera: THREE.PerspectiveCamera, up: Vec3): number {
  const side = new THREE.Vector3().crossVectors(new THREE.Vector3(...up), direction).normalize();
  const top = new THREE.Vector3().crossVectors(direction, side);
  const tan = Math.tan(THREE.MathUtils.degToRad(camera.fov / 2));
  const needed = points.map((point) => {
    const p = point.clone().sub(center);
    return p.dot(direction) + Math.max(Math.abs(p.dot(top)) / tan, Math.abs(p.dot(side)) / (tan * camera.aspect));
  });
  return 1.08 * Math.max(1e-3, ...needed);
}

/** Depth range: wide enough for all content, near enough to walk into it. */
export function nearFar(box: THREE.Box3, eye: THREE.Vector3, target: THREE.Vector3): { near: number; far: number } {
  const radius = box.getSize(new THREE.Vector3()).length() / 2 + 1e-3;
  const far = 4 * radius + 2 * eye.distanceTo(box.getCenter(new THREE.Vector3()));
  return { near: Math.max(far * 1e-5, Math.min(0.02 * eye.distanceTo(target), 0.05 * radius)), far };
}

/** How far the points are from the middle of the picture, as shares of its half width and half height. */
export function offCenter(points: THREE.Vector3[], camera: THREE.PerspectiveCamera): { x: number; y: number; size: number } {
  camera.updateMatrixWorld();
  const projected = points.map((point) => point.clone().project(camera));
  const ends = (values: number[]) => [Math.min(...values), Math.max(...values)];
  const [x0, x1] = ends(projected.map((p) => p.x));
  const [y0, y1] = ends(projected.map((p) => p.y));
  return { x: (x0 + x1) / 2, y: (y0 + y1) / 2, size: Math.max(x1 - x0, y1 - y0) / 2 };
}
