// SPDX-License-Identifier: Apache-2.0
// Lengths as text. A map of arbitrary scale has no meters until the person enters a known length.
import type { App } from '../app';

export function unitOf(app: App, run = app.state.active): string {
  const scene = app.runs[run]?.scene;
  return !scene || scene.scale.kind === 'metric' || app.scaleFactors.has(run) ? 'm' : 'units';
}

/** A length of a run with its sigma, such as "0.750 ± 0.004 m". */
export function lengthText(app: App, length: number, sigma: number | null, run = app.state.active): string {
  const factor = app.scaleFactors.get(run)?.factor ?? 1;
  const unit = unitOf(app, run);
  if (sigma === null) return withUnit(length * factor, unit);
  const places = decimalsFor(sigma * factor);
  return `${(length * factor).toFixed(places)} ± ${(sigma * factor).toFixed(places)} ${unit}`;
}

function withUnit(value: number, unit: string): string {
  const text = digits(value);
  return `${text} ${text === '1' && unit === 'units' ? 'unit' : unit}`;
}

/** One digit of the sigma is shown (two where it begins with 1), and the length to the same place. */
export function decimalsFor(sigma: number): number {
  if (!(sigma > 0)) return 4;
  const power = Math.floor(Math.log10(sigma) + 1e-9);
  const places = sigma / 10 ** power < 1.95 ? 1 - power : -power;
  return Math.min(9, Math.max(0, places));
}

export function digits(value: number): string {
  if (!Number.isFinite(value)) return 'unknown';
  return `${Number(value.toPrecision(3))}`;
}
