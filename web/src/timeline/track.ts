// SPDX-License-Identifier: Apache-2.0
// What the timeline shows, computed from the frames without drawing: stretches of one state, curves, places in time.
import type { Frames } from '../scene/scene';

export type CurveName = 'errors' | 'sigmas' | 'milliseconds';

export const curveLabels: Record<CurveName, string> = {
  errors: 'Error',
  sigmas: 'Position sigma',
  milliseconds: 'Time per frame',
};

export interface Stretch {
  from: number;
  to: number;
  state: number;
}

/** Between frames that are farther apart than this, nothing was recorded. */
export function longestStep(stamps: Float64Array): number {
  const steps = Float64Array.from(stamps.subarray(1), (s, i) => s - stamps[i]).sort();
  return Math.max(1, 10 * (steps[steps.length >> 1] ?? 0));
}

/** Consecutive frames of one state, as stamps from the first frame to the next stretch. */
export function stretches(frames: Frames): Stretch[] {
  const { stamps, states, count } = frames;
  const longest = longestStep(stamps);
  const result: Stretch[] = [];
  for (let i = 0; i < count; i++) {
    const state = states ? states[i] : -1;
    const last = result[result.length - 1];
    const joined = i + 1 < count && stamps[i + 1] - stamps[i] <= longest;
    const until = joined ? stamps[i + 1] : stamps[i];
    if (last && last.state === state && stamps[i] - last.to <= 1e-9) last.to = until;
    else result.push({ from: stamps[i], to: until, state });
  }
  return result;
}

/** Last frame at or before a stamp; the first frame for stamps before it. */
export function frameAt(stamps: Float64Array, stamp: number): number {
  let [low, high] = [0, stamps.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (stamps[middle] <= stamp) low = middle + 1;
    else high = middle;
  }
  return Math.max(0, low - 1);
}

/** Frame whose stamp is nearest. */
export function nearestFrame(stamps: Float64Array, stamp: number): number {
  const row = frameAt(stamps, stamp);
  return row + 1 < stamps.length && stamps[row + 1] - stamp < stamp - stamps[row] ? row + 1 : row;
}

/** Largest value in each of `columns` equal parts of the time; NaN where there is none. */
export function columnMaxima(frames: Frames, values: Float32Array, columns: number): Float32Array {
  const maxima = new Float32Array(columns).fill(NaN);
  const [first, last] = [frames.stamps[0], frames.stamps[frames.count - 1]];
  const span = Math.max(last - first, 1e-9);
  for (let i = 0; i < frames.count; i++) {
    if (!Number.isFinite(values[i])) continue;
    const column = Math.min(columns - 1, Math.floor(((frames.stamps[i] - first) / span) * columns));
    if (!(maxima[column] >= values[i])) maxima[column] = values[i];
  }
  return maxima;
}

/** Seconds as people read them: "3.20 s", "2:05.1", "1:02:05". */
export function duration(seconds: number): string {
  if (seconds < 60) return `${seconds.toFixed(2)} s`;
  const pad = (v: number, decimals = 0) => v.toFixed(decimals).padStart(decimals ? 3 + decimals : 2, '0');
  const whole = Math.floor(seconds);
  const [h, m] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60];
  return h > 0 ? `${h}:${pad(m)}:${pad(whole % 60)}` : `${m}:${pad(Math.floor((seconds % 60) * 10) / 10, 1)}`;
}

/** A step of the time axis with a readable length, for about `parts` parts. */
export function timeStep(span: number, parts: number): number {
  const steps = [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 43200, 86400];
  return steps.find((s) => span / s <= parts) ?? 86400 * Math.ceil(span / parts / 86400);
}
