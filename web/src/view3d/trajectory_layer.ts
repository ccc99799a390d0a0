// SPDX-License-Identifier: Apache-2.0
// One trajectory (final, online or ground truth) as a line of a few pixels' width, colored frame by frame.
import { Group, type Object3D } from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import type { Frames } from '../scene/scene';
import { hexToRgb, mapColor, okabeIto, shareOf, stateColor, type Rgb } from './colors';
import { longestStep } from '../timeline/track';
import { drawable } from './materials';
import { count, type LayerObject, type Style, type TrajectoryColor } from './style';

export type TrajectoryKind = 'final' | 'online' | 'truth';

const labels: Record<TrajectoryKind, string> = {
  final: 'Trajectory, final',
  online: 'Trajectory, online',
  truth: 'Ground truth',
};

export class TrajectoryLayer implements LayerObject {
  readonly key: string;
  readonly label: string;
  readonly detail: string;
  readonly object: Object3D;
  readonly shownAtFirst: boolean;
  private readonly geometry = new LineSegmentsGeometry();
  private readonly material: LineMaterial;
  private colored = '';
  /** Rows of the frames where a segment begins. */
  private readonly starts: number[];

  constructor(
    private readonly kind: TrajectoryKind,
    private readonly frames: Frames,
    private readonly stateNames: string[],
    private readonly runColor: string,
  ) {
    const positions = positionsOf(frames, kind)!;
    this.key = `trajectory:${kind}`;
    this.label = labels[kind];
    this.detail = count(frames.count, 'frame');
    this.shownAtFirst = kind !== 'online';
    this.starts = connected(frames.stamps, positions);
    if (this.starts.length > 0) this.geometry.setPositions(segments(positions, this.starts));
    this.material = new LineMaterial({ linewidth: kind === 'final' ? 3 : 2, vertexColors: kind === 'final' });
    this.object = this.starts.length > 0 ? new LineSegments2(this.geometry, this.material) : new Group();
    this.object.frustumCulled = false;
  }

  applyStyle(style: Style): void {
    if (this.starts.length === 0) return;
    if (this.kind === 'truth') this.material.color.set(style.dark ? '#ffffff' : '#000000');
    else if (this.kind === 'online') this.material.color.set(this.runColor);
    else this.recolor(style);
    this.material.opacity = this.kind === 'final' ? 1 : 0.6;
    this.material.transparent = this.kind !== 'final';
  }

  /** Only when the colors changed: a long trajectory has many. */
  private recolor(style: Style): void {
    const key = `${style.trajectoryColor} ${style.map}`;
    if (key === this.colored) return;
    this.colored = key;
    this.geometry.setColors(this.colors(style));
  }

  private colors(style: Style): Float32Array {
    const colors = new Float32Array(6 * this.starts.length);
    const mode = modesOf(this.frames).has(style.trajectoryColor) ? style.trajectoryColor : 'run';
    this.starts.forEach((row, i) => {
      const colorOf = (at: number) => colorOfFrame(this.frames, at, mode, style, this.stateNames, this.runColor);
      colors.set(colorOf(row), 6 * i);
      colors.set(colorOf(row + 1), 6 * i + 3);
    });
    return colors;
  }
}

/** Color of the trajectory at a frame; the frames must have what `mode` needs. */
export function colorOfFrame(frames: Frames, row: number, mode: TrajectoryColor, style: Style, stateNames: string[], runColor: string): Rgb {
  if (mode === 'run') return hexToRgb(runColor);
  if (mode === 'state') return hexToRgb(stateColor(stateNames[frames.states![row]]));
  const value = frameValue(frames, row, mode);
  const range = style.ranges[mode];
  return range && value !== null ? mapColor(style.map, shareOf(value, range)) : hexToRgb(okabeIto.gray);
}

export function positionsOf(frames: Frames, kind: TrajectoryKind): Float32Array | null {
  return kind === 'final' ? frames.positions : frames[kind];
}

/** Value of a frame by which it can be colored or plotted; null where it is not known. */
export function frameValue(frames: Frames, row: number, mode: 'error' | 'sigma' | 'time'): number | null {
  if (mode === 'time') return frames.stamps[row] - frames.stamps[0];
  const value = (mode === 'error' ? frames.errors : frames.sigmas)?.[row];
  return value === undefined || !Number.isFinite(value) ? null : value;
}

export function modesOf(frames: Frames): Set<TrajectoryColor> {
  const modes = new Set<TrajectoryColor>(['time', 'run']);
  if (frames.states) modes.add('state');
  if (frames.errors) modes.add('error');
  if (frames.sigmas) modes.add('sigma');
  return modes;
}

/** Rows that are joined with the next one. A gap in the stamps is not bridged: nobody knows the path there. */
function connected(stamps: Float64Array, positions: Float32Array): number[] {
  const gap = longestStep(stamps);
  const finite = (row: number) => drawable(positions, 3 * row);
  const starts: number[] = [];
  for (let row = 0; row + 1 < stamps.length; row++) {
    if (stamps[row + 1] - stamps[row] <= gap && finite(row) && finite(row + 1)) starts.push(row);
  }
  return starts;
}

function segments(positions: Float32Array, starts: number[]): Float32Array {
  const result = new Float32Array(6 * starts.length);
  starts.forEach((row, i) => result.set(positions.subarray(3 * row, 3 * row + 6), 6 * i));
  return result;
}
