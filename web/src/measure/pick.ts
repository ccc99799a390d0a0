// SPDX-License-Identifier: Apache-2.0
// The point under the cursor, by its distance on the screen. Runs over all points, so it is called on clicks only.
import type { Vec3 } from '../scene/scene';

export interface Candidates {
  /** What the points are, for the person: "landmarks". */
  source: string;
  run: number;
  positions: Float32Array;
  /** Numbers from one point to the next in `positions`. */
  stride: number;
  sigmas: Float32Array | null;
  /** Points above it are not drawn and cannot be picked. */
  maxSigma: number;
  /** They lie on what the map shows, so that faces and edges can be found among them. */
  surface: boolean;
}

export interface Picked {
  point: Vec3;
  /** Standard deviation of the position; null where the map does not say. */
  sigma: number | null;
  source: string;
  run: number;
  /** Pixels from one point to the next around the click; null where the point stands alone. */
  spacing: number | null;
}

export interface Projection {
  /** World to clip coordinates, column by column. */
  matrix: ArrayLike<number>;
  width: number;
  height: number;
}

/** Of points that are equally near within this many pixels, the one in front is meant. */
const tiePixels = 1.5;
/** Between the points of a surface, and beside its end, one sees what lies behind it: with so many of its points around the click, only what is about
    as far as they are is meant. Of points that stand alone, so many must be this near. */
const frontPixels = 6;
const frontCount = 3;
const frontDepth = 1.04;

interface Near {
  distance: number;
  depth: number;
  from: Candidates;
  row: number;
}

/** Of the points within the radius, in pixels, around the click. */
export function pick(candidates: Candidates[], view: Projection, x: number, y: number, radius: number): Picked | null {
  const near = candidates.flatMap((c) => within(c, view, x, y, radius));
  const depths = near.filter((n) => n.from.surface || n.distance <= frontPixels).map((n) => n.depth).sort((a, b) => a - b);
  const deepest = depths.length >= frontCount ? depths[frontCount - 1] * frontDepth : Infinity;
  const meant = near.filter((n) => n.depth <= deepest);
  const least = meant.reduce((d, n) => Math.min(d, n.distance), Infinity);
  let best: Near | null = null;
  for (const n of meant) if (n.distance <= least + tiePixels && (!best || n.depth < best.depth)) best = n;
  return best ? pickedOf(best.from, best.row, meant.length < 4 ? null : Math.sqrt((Math.PI * radius * radius) / meant.length)) : null;
}

function within(c: Candidates, view: Projection, x: number, y: number, radius: number): Near[] {
  const [m, p] = [view.matrix, c.positions];
  const [halfWidth, halfHeight] = [view.width / 2, view.height / 2];
  const found: Near[] = [];
  for (let i = 0, row = 0; i + 2 < p.length; i += c.stride, row++) {
    const w = m[3] * p[i] + m[7] * p[i + 1] + m[11] * p[i + 2] + m[15];
    if (!(w > 0)) continue;
    const dx = ((m[0] * p[i] + m[4] * p[i + 1] + m[8] * p[i + 2] + m[12]) / w + 1) * halfWidth - x;
    const dy = (1 - (m[1] * p[i] + m[5] * p[i + 1] + m[9] * p[i + 2] + m[13]) / w) * halfHeight - y;
    const d = dx * dx + dy * dy;
    if (!(d <= radius * radius) || (c.sigmas !== null && c.sigmas[row] > c.maxSigma)) continue;
    found.push({ distance: Math.sqrt(d), depth: w, from: c, row });
  }
  return found;
}

function pickedOf(c: Candidates, row: number, spacing: number | null): Picked {
  const i = row * c.stride;
  const sigma = c.sigmas ? c.sigmas[row] : NaN;
  return {
    point: [c.positions[i], c.positions[i + 1], c.positions[i + 2]],
    sigma: Number.isFinite(sigma) ? sigma : null,
    source: c.source,
    run: c.run,
    spacing,
  };
}
