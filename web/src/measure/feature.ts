// SPDX-License-Identifier: Apache-2.0
// What a click takes: a point, the straight edge near it, or the flat face under it.
import type { Vec3 } from '../scene/scene';
import type { Candidates, Picked } from './pick';
import { findEdge } from './edge';
import { along, dot, fitPlane, minus } from './plane';

export type FeatureKind = 'point' | 'edge' | 'face';

export interface Feature extends Picked {
  kind: FeatureKind;
  /** Along an edge, normal of a face; null of a point. Unit vector. */
  direction: Vec3 | null;
  /** A point of the face that an edge bounds. */
  face: Vec3 | null;
}

export interface Surroundings {
  /** What is shown of the run. */
  candidates: Candidates[];
  /** Around the click. */
  radius: number;
  /** Length of a pixel at the picked point. */
  perPixel: number;
  metric: boolean;
  /** Up in a planar map, where all points lie in one plane; else null. */
  upright: Vec3 | null;
}

/** Error common to all points of a face, and distance between the end of an object and of its depth: as `rastro measure` on clouds. */
const sharedSigma = 0.003;
const depthEdgeSigma = 0.012;
const pointingPixels = 3;
const leastEdgeRadius = 0.1;
const fewest = 40;
const most = 20000;

/** `perPixel`: length of a pixel at the point. Of a point among others on a surface it is not sure that it is the one that was meant. */
export function asPoint(picked: Picked, perPixel: number): Feature {
  const pointing = picked.spacing === null ? 0 : perPixel * Math.hypot(pointingPixels, picked.spacing);
  const sigma = picked.sigma === null ? null : Math.hypot(picked.sigma, pointing);
  return { ...picked, sigma, kind: 'point', direction: null, face: null };
}

/** The feature at a picked point; null where the points around it show none. */
export function featureAt(kind: FeatureKind, picked: Picked, around: Surroundings): Feature | null {
  if (kind === 'point') return asPoint(picked, around.perPixel);
  if (kind === 'edge' && around.upright) return null;
  // A short piece of a ragged edge does not tell its direction.
  let radius = kind === 'edge' && around.metric ? Math.max(around.radius, leastEdgeRadius) : around.radius;
  let points = near(around.candidates, picked, radius);
  for (let round = 0; points.length < fewest && round < 2; round++) points = near(around.candidates, picked, (radius *= 1.8));
  if (points.length < fewest) return null;
  return kind === 'edge' ? edgeAt(points, picked, radius, around) : faceAt(points, picked, radius, around);
}

function toleranceOf(radius: number, metric: boolean): number {
  return metric ? Math.min(0.006, 0.12 * radius) : 0.08 * radius;
}

function edgeAt(points: Vec3[], picked: Picked, radius: number, { metric }: Surroundings): Feature | null {
  const edge = findEdge(points, picked.point, radius, toleranceOf(radius, metric));
  if (!edge || Math.hypot(...minus(edge.point, picked.point)) > 0.7 * radius) return null;
  const sigma = Math.hypot(edge.sigma, metric ? Math.hypot(sharedSigma, depthEdgeSigma) : 0);
  return { ...picked, kind: 'edge', point: edge.point, direction: edge.direction, face: edge.face, sigma };
}

function faceAt(points: Vec3[], picked: Picked, radius: number, { metric, upright }: Surroundings): Feature | null {
  const plane = fitPlane(points, toleranceOf(radius, metric), upright);
  if (!plane || plane.rows.length < 0.3 * points.length) return null;
  const off = dot(plane.normal, minus(picked.point, plane.center));
  if (Math.abs(off) > 2 * toleranceOf(radius, metric)) return null;
  const sigma = Math.hypot(plane.scatter / Math.sqrt(Math.max(1, plane.rows.length / 4)), metric ? sharedSigma : 0.3 * plane.scatter);
  return { ...picked, kind: 'face', point: along(picked.point, -off, plane.normal), direction: plane.normal, face: null, sigma };
}

/** Points of the same run within the radius, evenly thinned where they are many. */
function near(candidates: Candidates[], picked: Picked, radius: number): Vec3[] {
  const [x, y, z] = picked.point;
  const found: Vec3[] = [];
  for (const c of candidates) {
    if (c.run !== picked.run || !c.surface) continue;
    const p = c.positions;
    for (let i = 0, row = 0; i + 2 < p.length; i += c.stride, row++) {
      if (Math.abs(p[i] - x) > radius || Math.abs(p[i + 1] - y) > radius || Math.abs(p[i + 2] - z) > radius) continue;
      if (c.sigmas !== null && c.sigmas[row] > c.maxSigma) continue;
      if ((p[i] - x) ** 2 + (p[i + 1] - y) ** 2 + (p[i + 2] - z) ** 2 <= radius * radius) found.push([p[i], p[i + 1], p[i + 2]]);
    }
  }
  const step = Math.ceil(found.length / most);
  return step > 1 ? found.filter((_, i) => i % step === 0) : found;
}

export interface Span {
  /** Ends of the line to draw: as far apart as the length. */
  a: Vec3;
  b: Vec3;
  length: number;
  sigma: number | null;
}

/** People click on parallel things; what was found at their ends may deviate by so much. */
const parallel = (25 * Math.PI) / 180;

/**
 * Length between two features: along the normal of faces, perpendicular to edges, else from point to point. Null where
 * they are not parallel. The ends' sigmas are those of one axis, thus also of the axis along the line; both ends are
 * taken as independent. `scaleSigma` is the relative sigma of the map's scale: it lengthens every length alike.
 */
export function spanBetween(a: Feature, b: Feature, scaleSigma: number | null): Span | null {
  const axis = commonAxis(a, b);
  if (axis === null) return null;
  const whole = minus(b.point, a.point);
  const share = axis === 'none' ? 0 : dot(whole, axis.direction);
  const between = axis === 'none' ? whole : axis.kind === 'face'
    ? along([0, 0, 0], share, axis.direction) : along(whole, -share, axis.direction);
  const length = Math.hypot(...between);
  const middle = along(a.point, 0.5, whole);
  const sigma = a.sigma === null || b.sigma === null ? null : Math.hypot(a.sigma, b.sigma, length * (scaleSigma ?? 0));
  return { a: along(middle, -0.5, between), b: along(middle, 0.5, between), length, sigma };
}

/** Of the faces where there is one, else of the edges; null where two of them are not parallel. */
function commonAxis(a: Feature, b: Feature): { kind: FeatureKind; direction: Vec3 } | 'none' | null {
  const kind = [a, b].some((f) => f.kind === 'face') ? 'face' : [a, b].some((f) => f.kind === 'edge') ? 'edge' : 'point';
  if (kind === 'point') return 'none';
  const [first, second] = [a, b].filter((f) => f.kind === kind).map((f) => f.direction!);
  const edge = kind === 'face' ? [a, b].find((f) => f.kind === 'edge') : undefined;
  // An edge that runs into a face has no distance from it.
  if (edge && Math.abs(dot(edge.direction!, first)) > Math.sin(parallel)) return null;
  if (!second) return { kind, direction: first };
  const cosine = dot(first, second);
  if (Math.abs(cosine) < Math.cos(parallel)) return null;
  const sum = along(first, Math.sign(cosine), second);
  const norm = Math.hypot(...sum);
  return { kind, direction: [sum[0] / norm, sum[1] / norm, sum[2] / norm] };
}
