// SPDX-License-Identifier: Apache-2.0
// What the person has chosen. All of it stands in the address after "#", so that a view can be linked.
import type { MapName } from './view3d/colors';
import type { PointColor, TrajectoryColor } from './view3d/style';

export type Theme = 'auto' | 'light' | 'dark';

export interface State {
  /** Layers that were switched by hand; the others are as they begin. */
  layers: Record<string, boolean>;
  /** Runs that are switched off. */
  hiddenRuns: number[];
  /** The run whose timeline is shown. */
  active: number;
  frame: number;
  pointColor: PointColor;
  trajectoryColor: TrajectoryColor;
  map: MapName;
  pointSize: number;
  maxSigma: number;
  cameraSize: number;
  ellipsoidScale: number;
  theme: Theme;
  /** Eye and target; null: the whole content. */
  camera: number[] | null;
}

const pointColors: PointColor[] = ['image', 'height', 'age', 'uncertainty', 'run'];
const trajectoryColors: TrajectoryColor[] = ['state', 'error', 'sigma', 'time', 'run'];

export function toHash(state: State, initial: State): string {
  const parts = new URLSearchParams();
  const put = (key: string, value: string, first: string) => {
    if (value !== first) parts.set(key, value);
  };
  const switched = Object.entries(state.layers);
  if (switched.length) parts.set('layers', switched.map(([key, on]) => `${on ? '+' : '-'}${key}`).join(','));
  if (state.hiddenRuns.length) parts.set('off', state.hiddenRuns.join(','));
  put('run', `${state.active}`, `${initial.active}`);
  put('frame', `${state.frame}`, `${initial.frame}`);
  put('points', state.pointColor, initial.pointColor);
  put('trajectory', state.trajectoryColor, initial.trajectoryColor);
  put('map', state.map, initial.map);
  put('size', `${state.pointSize}`, `${initial.pointSize}`);
  put('sigma', `${state.maxSigma}`, `${initial.maxSigma}`);
  put('cameras', short(state.cameraSize), short(initial.cameraSize));
  put('ellipsoids', `${state.ellipsoidScale}`, `${initial.ellipsoidScale}`);
  put('theme', state.theme, initial.theme);
  if (state.camera) parts.set('view', state.camera.map(short).join(','));
  return parts.toString().replaceAll('%2C', ',').replaceAll('%3A', ':');
}

/** Unknown or broken parts of the address are passed over: an old link must still open. */
export function fromHash(hash: string, initial: State): State {
  const parts = new URLSearchParams(hash.replace(/^#/, ''));
  const number = (key: string, fallback: number) => {
    const value = Number(parts.get(key) ?? NaN);
    return Number.isFinite(value) ? value : fallback;
  };
  const view = (parts.get('view') ?? '').split(',').map(Number);
  return {
    layers: layersOf(parts.get('layers') ?? ''),
    hiddenRuns: (parts.get('off') ?? '').split(',').filter((v) => /^\d+$/.test(v)).map(Number),
    active: Math.max(0, Math.round(number('run', initial.active))),
    frame: Math.max(0, Math.round(number('frame', initial.frame))),
    pointColor: oneOf(pointColors, parts.get('points'), initial.pointColor),
    trajectoryColor: oneOf(trajectoryColors, parts.get('trajectory'), initial.trajectoryColor),
    map: oneOf(['viridis', 'cividis'], parts.get('map'), initial.map),
    pointSize: clamp(number('size', initial.pointSize), 1, 12),
    maxSigma: Math.max(0, number('sigma', initial.maxSigma)),
    cameraSize: Math.max(0, number('cameras', initial.cameraSize)),
    ellipsoidScale: clamp(number('ellipsoids', initial.ellipsoidScale), 1, 1000),
    theme: oneOf(['auto', 'light', 'dark'], parts.get('theme'), initial.theme),
    camera: view.length === 6 && view.every(Number.isFinite) ? view : null,
  };
}

/** The same for runs with so many frames each: what lies behind their end is the last one. */
export function withinRuns(state: State, frames: number[]): State {
  const active = Math.min(state.active, Math.max(0, frames.length - 1));
  return { ...state, active, frame: Math.min(state.frame, Math.max(0, (frames[active] ?? 0) - 1)) };
}

function layersOf(text: string): Record<string, boolean> {
  // In a query a plus sign is read as a space.
  const entries = text.split(',').filter((t) => /^[ +-]./.test(t)).map((t) => [t.slice(1), t[0] !== '-'] as const);
  return Object.fromEntries(entries);
}

function oneOf<T extends string>(known: T[], value: string | null, fallback: T): T {
  return known.includes(value as T) ? (value as T) : fallback;
}

function clamp(value: number, low: number, high: number): number {
  return Math.min(high, Math.max(low, value));
}

function short(value: number): string {
  return `${Number(value.toPrecision(6))}`;
}
