// SPDX-License-Identifier: Apache-2.0
// The trajectory of a run that goes on: new frames are added at the end of the buffers, nothing before is touched.
import { DynamicDrawUsage, Group, InstancedInterleavedBuffer, InterleavedBufferAttribute } from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import type { Frames } from '../scene/scene';
import { longestStep } from '../timeline/track';
import { drawable } from './materials';
import { count, type LayerObject, type Style } from './style';
import { colorOfFrame, modesOf, positionsOf } from './trajectory_layer';

/** What is drawn, as it stands; `version` changes when earlier rows have changed. */
export interface GrowingFrames {
  frames: Frames | null;
  version: number;
  stateNames: string[];
}

export class GrowingTrajectory implements LayerObject {
  readonly key: string;
  readonly label: string;
  readonly object = new Group();
  readonly shownAtFirst: boolean;
  private readonly material: LineMaterial;
  private line: LineSegments2 | null = null;
  private positions = buffer(0);
  private colors = buffer(0);
  private segments = 0;
  /** Row of the frames where each segment begins. */
  private starts: number[] = [];
  private rows = 0;
  private version = -1;
  private gap = 1;
  private style: Style | null = null;

  constructor(private readonly kind: 'final' | 'online', private readonly record: GrowingFrames, private readonly runColor: string) {
    this.key = `trajectory:${kind}`;
    this.label = kind === 'final' ? 'Trajectory' : 'Trajectory, online';
    this.shownAtFirst = kind === 'final';
    this.material = new LineMaterial({ linewidth: kind === 'final' ? 3 : 2, vertexColors: kind === 'final' });
    if (kind === 'online') Object.assign(this.material, { transparent: true, opacity: 0.6 });
  }

  get detail(): string {
    return count(this.record.frames?.count ?? 0, 'frame');
  }

  applyStyle(style: Style): void {
    const before = this.style;
    this.style = style;
    if (this.kind === 'online') return void this.material.color.set(this.runColor);
    const mode = style.trajectoryColor as keyof Style['ranges'];
    const same = before && before.trajectoryColor === style.trajectoryColor && before.map === style.map && `${before.ranges[mode]}` === `${style.ranges[mode]}`;
    if (!same) this.recolor();
  }

  /** Takes over the frames that came since the last call. */
  grow(): void {
    const { frames, version } = this.record;
    if (version !== this.version || (frames?.count ?? 0) < this.rows) this.restart();
    if (!frames) return;
    // How far apart frames usually are becomes known as they come.
    if (this.rows < 2 || frames.count > 2 * this.rows) this.gap = longestStep(frames.stamps);
    const positions = positionsOf(frames, this.kind)!;
    const first = this.segments;
    for (let row = Math.max(0, this.rows - 1); row + 1 < frames.count; row++) {
      const joined = frames.stamps[row + 1] - frames.stamps[row] <= this.gap;
      if (joined && drawable(positions, 3 * row) && drawable(positions, 3 * row + 3)) this.add(frames, positions, row);
    }
    this.rows = frames.count;
    if (this.segments > first) this.upload(first);
  }

  private restart(): void {
    this.version = this.record.version;
    this.rows = this.segments = this.starts.length = 0;
    if (this.line) this.line.geometry.instanceCount = 0;
  }

  private add(frames: Frames, positions: Float32Array, row: number): void {
    if (6 * (this.segments + 1) > this.positions.array.length) this.enlarge();
    this.positions.array.set(positions.subarray(3 * row, 3 * row + 6), 6 * this.segments);
    this.starts[this.segments] = row;
    this.paint(frames, this.segments++);
  }

  private paint(frames: Frames, segment: number): void {
    if (!this.style || this.kind === 'online') return;
    const row = this.starts[segment];
    const mode = modesOf(frames).has(this.style.trajectoryColor) ? this.style.trajectoryColor : 'run';
    for (const end of [0, 1]) {
      const color = colorOfFrame(frames, row + end, mode, this.style, this.record.stateNames, this.runColor);
      this.colors.array.set(color, 6 * segment + 3 * end);
    }
  }

  private recolor(): void {
    const { frames } = this.record;
    if (!frames) return;
    for (let i = 0; i < this.segments; i++) this.paint(frames, i);
    this.upload(0);
  }

  /** A graphics card's buffer cannot grow: a larger one takes its place, twice as large, so that it happens rarely. */
  private enlarge(): void {
    const [positions, colors] = [this.positions.array, this.colors.array];
    const capacity = Math.max(256, 2 * (positions.length / 6));
    [this.positions, this.colors] = [buffer(capacity), buffer(capacity)];
    this.positions.array.set(positions);
    this.colors.array.set(colors);
    const geometry = new LineSegmentsGeometry();
    const share = (name: string, from: InstancedInterleavedBuffer, at: number) => geometry.setAttribute(name, new InterleavedBufferAttribute(from, 3, at));
    share('instanceStart', this.positions, 0);
    share('instanceEnd', this.positions, 3);
    share('instanceColorStart', this.colors, 0);
    share('instanceColorEnd', this.colors, 3);
    this.line?.geometry.dispose();
    if (this.line) this.object.remove(this.line);
    this.line = new LineSegments2(geometry, this.material);
    this.line.frustumCulled = false;
    this.object.add(this.line);
  }

  private upload(first: number): void {
    if (!this.line) return;
    this.line.geometry.instanceCount = this.segments;
    for (const each of [this.positions, this.colors]) {
      each.addUpdateRange(6 * first, 6 * (this.segments - first));
      each.needsUpdate = true;
    }
  }
}

function buffer(capacity: number): InstancedInterleavedBuffer {
  const result = new InstancedInterleavedBuffer(new Float32Array(6 * capacity), 6, 1);
  result.setUsage(DynamicDrawUsage);
  return result;
}
