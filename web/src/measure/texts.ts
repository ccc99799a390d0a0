// SPDX-License-Identifier: Apache-2.0
// Lengths as text, with their error bar, in meters where the scale is known.
import type { App } from '../app';
import type { NamedLength } from '../scene/scene';
import { decimalsFor, digits } from '../ui/units';
import { scaled, type Length } from './length';
import type { Measured } from './measure';

export function measuredOf(app: App, item: Measured): string {
  return item.known !== null ? `${item.known} m (known)` : text(app, item.measured, item.run);
}

export function lengthOf(app: App, length: NamedLength, run: number): string {
  return text(app, { length: length.length, sigma: length.sigma }, run);
}

function text(app: App, length: Length, run: number): string {
  const scale = app.scaleFactors.get(run);
  const shown = scale ? scaled(length, scale) : length;
  const unit = scale || app.runs[run].scene.scale.kind === 'metric' ? 'm' : 'units';
  return withSigma(shown, unit);
}

/** "0.750 ± 0.004 m"; "0.7500 m ± unknown" where the sigma of an end is not known. */
export function withSigma({ length, sigma }: Length, unit: string): string {
  if (sigma === null) return `${length >= 1000 ? digits(length) : Number(length.toPrecision(4))} ${unit} ± unknown`;
  const places = decimalsFor(sigma);
  return `${length.toFixed(places)} ± ${sigma.toFixed(places)} ${unit}`;
}
