// SPDX-License-Identifier: Apache-2.0
// The flat face on which most points around a click lie: drawn planes (RANSAC), refined by principal axes.
import type { Vec3 } from '../scene/scene';

export interface Plane {
  center: Vec3;
  /** Unit vector. */
  normal: Vec3;
  /** Rows of the points on it. */
  rows: number[];
  /** Root mean square distance of those points. */
  scatter: number;
}

const draws = 200;
const mostVoters = 600;

export function dot(a: Vec3, b: Vec3): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

export function cross(a: Vec3, b: Vec3): Vec3 {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

export function along(a: Vec3, share: number, b: Vec3): Vec3 {
  return [a[0] + share * b[0], a[1] + share * b[1], a[2] + share * b[2]];
}

export function minus(a: Vec3, b: Vec3): Vec3 {
  return along(a, -1, b);
}

export function unit(a: Vec3): Vec3 {
  const norm = Math.hypot(...a);
  return norm > 0 ? [a[0] / norm, a[1] / norm, a[2] / norm] : [0, 0, 0];
}

/**
 * `tolerance`: largest distance of a point on the plane. `upright`: in a planar map all points lie in one plane, and a
 * face is a wall along this axis. The same points give the same plane.
 */
export function fitPlane(points: Vec3[], tolerance: number, upright: Vec3 | null): Plane | null {
  if (points.length < 12) return null;
  let plane = drawn(points, tolerance, upright);
  for (let round = 0; plane && round < 4; round++) plane = refined(points, plane, tolerance, upright);
  return plane && plane.rows.length >= 12 ? plane : null;
}

function drawn(points: Vec3[], tolerance: number, upright: Vec3 | null): Plane | null {
  const voters = evenly(points, mostVoters);
  const next = sequence();
  let best: Plane | null = null;
  let most = 0;
  for (let i = 0; i < draws; i++) {
    const [a, b, c] = [0, 0, 0].map(() => voters[next() % voters.length]);
    const normal = unit(cross(minus(b, a), upright ?? minus(c, a)));
    if (normal.every((v) => v === 0)) continue;
    let votes = 0;
    for (const p of voters) if (Math.abs(dot(normal, minus(p, a))) <= tolerance) votes++;
    if (votes > most) [most, best] = [votes, { center: a, normal, rows: [], scatter: 0 }];
  }
  return best;
}

function refined(points: Vec3[], plane: Plane, tolerance: number, upright: Vec3 | null): Plane | null {
  const rows = [...points.keys()].filter((row) => Math.abs(dot(plane.normal, minus(points[row], plane.center))) <= tolerance);
  if (rows.length < 3) return null;
  const center: Vec3 = [0, 0, 0];
  for (const row of rows) for (let axis = 0; axis < 3; axis++) center[axis] += points[row][axis] / rows.length;
  const scatter = [0, 0, 0, 0, 0, 0, 0, 0, 0];
  for (const row of rows) add(scatter, minus(points[row], center), 1 / rows.length);
  // All along the axis is on the face, so that the least scatter is found across it.
  if (upright) add(scatter, upright, scatter[0] + scatter[4] + scatter[8]);
  const normal = leastAxis(scatter, plane.normal);
  const square = rows.reduce((sum, row) => sum + dot(normal, minus(points[row], center)) ** 2, 0) / rows.length;
  return { center, normal, rows, scatter: Math.sqrt(square) };
}

function add(matrix: number[], v: Vec3, weight: number): void {
  for (let i = 0; i < 9; i++) matrix[i] += weight * v[Math.floor(i / 3)] * v[i % 3];
}

/** Axis of the least scatter: the largest of (trace - matrix), found by powers from a start near it. */
function leastAxis(m: number[], start: Vec3): Vec3 {
  const trace = m[0] + m[4] + m[8];
  let axis = start;
  for (let i = 0; i < 100; i++) {
    const product: Vec3 = [dot([m[0], m[1], m[2]], axis), dot([m[3], m[4], m[5]], axis), dot([m[6], m[7], m[8]], axis)];
    const next = unit(minus([trace * axis[0], trace * axis[1], trace * axis[2]], product));
    if (next.every((v) => v === 0)) return axis;
    axis = next;
  }
  return axis;
}

function evenly<T>(items: T[], most: number): T[] {
  const step = Math.max(1, items.length / most);
  return Array.from({ length: Math.min(items.length, most) }, (_, i) => items[Math.floor(i * step)]);
}

/** Numbers that repeat: the same click measures the same. */
function sequence(): () => number {
  let state = 12345;
  return () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) >>> 8;
}
