// SPDX-License-Identifier: Apache-2.0
// A length with its standard deviation, and the scale that a known length gives.

export interface Length {
  length: number;
  /** Null where the sigma of an end is not known. */
  sigma: number | null;
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
