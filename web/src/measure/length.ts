// SPDX-License-Identifier: Apache-2.0
// Length between two points of a map, with its standard deviation.
import type { Vec3 } from '../scene/scene';
import type { Picked } from './pick';

export interface Length {
  length: number;
  /** Null where the sigma of an end is not known. */
  sigma: number | null;
}

export function distance(a: Vec3, b: Vec3): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/**
 * The ends' sigmas are those of one axis, thus also of the axis along the line; both ends are taken as independent.
 * `scaleSigma` is the relative sigma of the map's scale: it lengthens or shortens every length alike.
 */
export function lengthBetween(a: Picked, b: Picked, scaleSigma: number | null): Length {
  const length = distance(a.point, b.point);
  if (a.sigma === null || b.sigma === null) return { length, sigma: null };
  return { length, sigma: Math.hypot(a.sigma, b.sigma, length * (scaleSigma ?? 0)) };
}

export interface ScaleFactor {
  /** Meters for one unit of the map. */
  factor: number;
  /** Relative sigma of the factor; null where that of the measured length is not known. */
  sigma: number | null;
}

/** Scale of a map in which something of known length was measured. The known length is taken as exact. */
export function scaleFrom(measured: Length, knownMeters: number): ScaleFactor | null {
  if (!(measured.length > 0) || !(knownMeters > 0) || !Number.isFinite(knownMeters)) return null;
  return { factor: knownMeters / measured.length, sigma: measured.sigma === null ? null : measured.sigma / measured.length };
}

/** A length in the map's unit brought to meters, with the sigma of the scale. */
export function scaled(length: Length, scale: ScaleFactor): Length {
  const sigma = length.sigma === null || scale.sigma === null ? null : Math.hypot(length.sigma, length.length * scale.sigma);
  return { length: length.length * scale.factor, sigma: sigma === null ? null : sigma * scale.factor };
}
