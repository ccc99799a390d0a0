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
}

export interface Projection {
  /** World to clip coordinates, column by column. */
  matrix: ArrayLike<number>;
  width: number;
  height: number;
}

/** Of points that are equally near within this many pixels, the one in front is meant. */
export const tiePixels = 1.5;

interface Best {
  distance: number;
  depth: number;
  from: Candidates | null;
  row: number;
}

/** `tie`: as `tiePixels`; for an edge, which ends in front of something else, the whole radius. */
export function pick(candidates: Candidates[], view: Projection, x: number, y: number, radius: number, tie = tiePixels): Picked | null {
  let nearest = radius;
  for (const c of candidates) nearest = Math.min(nearest, visit(c, view, x, y, radius, null));
  const best: Best = { distance: Math.min(radius, nearest + tie), depth: Infinity, from: null, row: 0 };
  for (const c of candidates) visit(c, view, x, y, best.distance, best);
  return best.from ? pickedOf(best.from, best.row) : null;
}

/** Smallest distance on the screen; with `best`, notes the foremost point within `radius`. */
function visit(c: Candidates, view: Projection, x: number, y: number, radius: number, best: Best | null): number {
  const [m, p] = [view.matrix, c.positions];
  const [halfWidth, halfHeight] = [view.width / 2, view.height / 2];
  let least = radius * radius;
  const limit = least;
  for (let i = 0, row = 0; i + 2 < p.length; i += c.stride, row++) {
    const w = m[3] * p[i] + m[7] * p[i + 1] + m[11] * p[i + 2] + m[15];
    if (!(w > 0)) continue;
    const dx = ((m[0] * p[i] + m[4] * p[i + 1] + m[8] * p[i + 2] + m[12]) / w + 1) * halfWidth - x;
    const dy = (1 - (m[1] * p[i] + m[5] * p[i + 1] + m[9] * p[i + 2] + m[13]) / w) * halfHeight - y;
    const d = dx * dx + dy * dy;
    if (!(d <= limit) || (c.sigmas !== null && c.sigmas[row] > c.maxSigma)) continue;
    if (d < least) least = d;
    if (best && w < best.depth) Object.assign(best, { depth: w, from: c, row });
  }
  return Math.sqrt(least);
}

function pickedOf(c: Candidates, row: number): Picked {
  const i = row * c.stride;
  const sigma = c.sigmas ? c.sigmas[row] : NaN;
  return {
    point: [c.positions[i], c.positions[i + 1], c.positions[i + 2]],
    sigma: Number.isFinite(sigma) ? sigma : null,
    source: c.source,
    run: c.run,
  };
}
