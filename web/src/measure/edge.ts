// SPDX-License-Identifier: Apache-2.0
// A straight edge near a click: where the points of a face end, or where two faces meet.
import type { Vec3 } from '../scene/scene';
import { along, cross, dot, fitPlane, minus, unit, type Plane } from './plane';

export interface Edge {
  /** Its point nearest to the click. */
  point: Vec3;
  /** Unit vector along it. */
  direction: Vec3;
  /** A point of the face that it bounds. */
  face: Vec3;
  /** Standard deviation of its position across it, from the points. */
  sigma: number;
}

const angles = 120;
const fewestSlices = 4;

/** `points` lie within `radius` of `click`; `tolerance` is that of the plane. */
export function findEdge(points: Vec3[], click: Vec3, radius: number, tolerance: number): Edge | null {
  const plane = fitPlane(points, tolerance, null);
  if (!plane) return null;
  // The front of a box ends where its side begins, and both end below: the edge nearest to the click is meant.
  const edges = [boundary(points, plane, click, radius), crease(points, plane, click, radius, tolerance)].filter((e): e is Edge => e !== null);
  const off = (e: Edge) => Math.hypot(...cross(e.direction, minus(click, e.point)));
  return edges.sort((a, b) => off(a) - off(b))[0] ?? null;
}

/** Distance of neighboring points on a face. */
function spacingOf(plane: Plane, radius: number): number {
  return Math.sqrt((Math.PI * radius * radius) / plane.rows.length);
}

interface Line {
  /** Of the ends over the place along the edge: end = offset + slope * place. */
  offset: number;
  slope: number;
  spread: number;
  slices: number;
}

function boundary(points: Vec3[], plane: Plane, click: Vec3, radius: number): Edge | null {
  const spacing = spacingOf(plane, radius);
  const foot = along(click, -dot(plane.normal, minus(click, plane.center)), plane.normal);
  const first = unit(cross(plane.normal, Math.abs(plane.normal[0]) < 0.8 ? [1, 0, 0] : [0, 1, 0]));
  const second = cross(plane.normal, first);
  const flat = plane.rows.map((row) => [dot(first, minus(points[row], foot)), dot(second, minus(points[row], foot))]);
  let best: { cost: number; out: Vec3; line: Line } | null = null;
  for (let i = 0; i < angles; i++) {
    const angle = (2 * Math.PI * i) / angles;
    const line = endsTowards(flat, Math.cos(angle), Math.sin(angle), radius, spacing);
    if (!line || Math.abs(line.slope) > 0.06) continue;
    const cost = line.spread + Math.abs(line.offset) + 0.5 * radius * Math.abs(line.slope);
    const out = along([Math.cos(angle) * first[0], Math.cos(angle) * first[1], Math.cos(angle) * first[2]], Math.sin(angle), second);
    if (!best || cost < best.cost) best = { cost, out, line };
  }
  if (!best) return null;
  const { out, line } = best;
  const direction = unit(along(cross(plane.normal, out), line.slope, out));
  // The outermost points of a face lie half a spacing inside its end on average.
  const point = along(foot, line.offset + 0.25 * spacing, out);
  return { point, direction, face: along(point, -0.4 * radius, out), sigma: Math.hypot(line.spread / Math.sqrt(line.slices), 0.3 * spacing) };
}

/** Ends of the points towards one direction, slice by slice; null where the face goes on, or is too thin. */
function endsTowards(flat: number[][], x: number, y: number, radius: number, spacing: number): Line | null {
  const width = Math.max(2 * spacing, radius / 8);
  const half = Math.floor((0.7 * radius) / width);
  const slices: number[][] = Array.from({ length: 2 * half + 1 }, () => []);
  for (const [u, v] of flat) {
    const slice = Math.round((x * v - y * u) / width) + half;
    if (slice >= 0 && slice < slices.length) slices[slice].push(x * u + y * v);
  }
  const ends: [number, number][] = [];
  let going = 0;
  slices.forEach((places, i) => {
    const at = (i - half) * width;
    const end = endOf(places, 2.5 * spacing, -0.5 * radius);
    // Beyond this the neighborhood of the click ends, not the face.
    if (end !== null && end > Math.sqrt(radius * radius - at * at) - 3 * spacing) going++;
    else if (end !== null) ends.push([at, end]);
  });
  if (ends.length < fewestSlices || ends.length < 0.6 * slices.length || going > 0.2 * slices.length) return null;
  return lineThrough(ends);
}

/** Walks outwards from `start` until there is no point over a distance of `gap`. */
function endOf(places: number[], gap: number, start: number): number | null {
  let last: number | null = null;
  for (const place of places.sort((a, b) => a - b)) {
    if (place < start) continue;
    if (place - (last ?? start) > gap) break;
    last = place;
  }
  return last;
}

/** Least squares, then once more without the ends that do not agree. */
function lineThrough(ends: [number, number][]): Line {
  let line = regression(ends);
  const off = (end: [number, number]) => Math.abs(end[1] - line.offset - line.slope * end[0]);
  const limit = Math.max(1e-9, 3 * [...ends].map(off).sort((a, b) => a - b)[ends.length >> 1]);
  const kept = ends.filter((end) => off(end) <= limit);
  if (kept.length >= fewestSlices) line = regression(kept);
  return line;
}

function regression(ends: [number, number][]): Line {
  const n = ends.length;
  const [mx, my] = [0, 1].map((k) => ends.reduce((sum, end) => sum + end[k], 0) / n);
  const square = ends.reduce((sum, end) => sum + (end[0] - mx) ** 2, 0);
  const slope = square > 0 ? ends.reduce((sum, end) => sum + (end[0] - mx) * (end[1] - my), 0) / square : 0;
  const offset = my - slope * mx;
  const spread = Math.sqrt(ends.reduce((sum, end) => sum + (end[1] - offset - slope * end[0]) ** 2, 0) / Math.max(1, n - 2));
  return { offset, slope, spread, slices: n };
}

/** Where the face of most points and the one of most others meet. */
function crease(points: Vec3[], plane: Plane, click: Vec3, radius: number, tolerance: number): Edge | null {
  const on = new Set(plane.rows);
  const others = points.filter((p, row) => !on.has(row) && Math.abs(dot(plane.normal, minus(p, plane.center))) > 1.5 * tolerance);
  const other = fitPlane(others, tolerance, null);
  if (!other || other.rows.length < 0.1 * plane.rows.length) return null;
  const axis = cross(plane.normal, other.normal);
  const sine = Math.hypot(...axis);
  if (sine < 0.4) return null;
  const direction = unit(axis);
  // From the click to the line: first onto one plane, then within it onto the other.
  const foot = along(click, -dot(plane.normal, minus(click, plane.center)), plane.normal);
  const within = cross(direction, plane.normal);
  const point = along(foot, -dot(other.normal, minus(foot, other.center)) / dot(other.normal, within), within);
  if (Math.hypot(...minus(point, click)) > 0.5 * radius) return null;
  const inwards = Math.sign(dot(within, minus(plane.center, point))) || 1;
  const part = (p: Plane) => p.scatter / Math.sqrt(Math.max(1, p.rows.length / 4));
  return { point, direction, face: along(point, 0.4 * radius * inwards, within), sigma: Math.hypot(part(plane), part(other)) / sine };
}
