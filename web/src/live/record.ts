// SPDX-License-Identifier: Apache-2.0
// All frames of the run so far, by time: those this page was told of, and those that a scene brought.
import type { Frames, SceneEvent } from '../scene/scene';
import { isMarked } from '../timeline/strip';
import { f32, f64, u8 } from './columns';
import { mergedRows, type RowPair } from './merged_rows';
import { eventOf, type LiveFrame } from './messages';

/** Words and stage times are kept for this many frames: an hour's run must not fill the page's memory. */
const keptDetails = 20000;
const badStates = ['weak', 'lost', 'initializing', 'relocalized'];

function columns() {
  return { stamps: f64(1), positions: f32(3), orientations: f32(4), online: f32(3), states: u8(1), sigmas: f32(1), errors: f32(1), milliseconds: f32(1) };
}

const unknownPose = [NaN, NaN, NaN, NaN, NaN, NaN, NaN];

export class LiveRecord {
  count = 0;
  /** Grows whenever rows that were there already have changed; else only rows were added. */
  version = 0;
  stateNames: string[] = ['tracking', 'weak', 'lost', 'relocalized', 'initializing'];
  details: (LiveFrame | null)[] = [];
  events: SceneEvent[] = [];
  private data = columns();
  private hasErrors = false;
  /** Of the last frame that this page was told of. */
  lastIndex = -1;

  /** The frames as the page's other parts know them; null before the first. */
  get frames(): Frames | null {
    const n = this.count;
    if (n === 0) return null;
    const d = this.data;
    return {
      count: n, stamps: d.stamps.view(n), positions: d.positions.view(n), orientations: d.orientations.view(n), online: d.online.view(n),
      states: d.states.view(n), sigmas: d.sigmas.view(n), errors: this.hasErrors ? d.errors.view(n) : null, truth: null,
      milliseconds: d.milliseconds.view(n),
    };
  }

  get lastStamp(): number {
    return this.count ? this.data.stamps.view(this.count)[this.count - 1] : -Infinity;
  }

  /** False for a frame that was told before, or whose time goes back. */
  append(frame: LiveFrame): boolean {
    if (frame.index <= this.lastIndex || frame.stamp < this.lastStamp) return false;
    const [row, d, pose] = [this.count++, this.data, frame.pose ?? unknownPose];
    d.stamps.set(row, frame.stamp);
    d.positions.set(row, pose[0], pose[1], pose[2]);
    d.online.set(row, pose[0], pose[1], pose[2]);
    d.orientations.set(row, pose[3], pose[4], pose[5], pose[6]);
    d.states.set(row, frame.state);
    d.sigmas.set(row, frame.sigma ?? NaN);
    d.errors.set(row, NaN);
    d.milliseconds.set(row, frame.ms ?? NaN);
    this.lastIndex = frame.index;
    this.details[row] = frame;
    if (row >= keptDetails) this.details[row - keptDetails] = null;
    this.noteEvents(frame, row);
    return true;
  }

  /** Another run has begun behind the same address. */
  clear(): void {
    Object.assign(this, { count: 0, details: [], events: [], data: columns(), hasErrors: false, lastIndex: -1 });
    this.version++;
  }

  /** What the map knows by now: poses as optimized, frames this page was not told of. */
  merge(frames: Frames, names: string[]): void {
    const own = this.frames;
    const pairs = mergedRows(own?.stamps ?? new Float64Array(0), frames.stamps);
    const states = frames.states && this.translated(frames.states, names);
    const [old, details] = [this.data, this.details];
    if (pairs.length !== this.count) {
      this.data = columns();
      this.details = pairs.map((p) => (p.own >= 0 ? details[p.own] ?? null : null));
    }
    pairs.forEach((pair, row) => this.mergeRow(row, pair, old, frames, states));
    this.count = pairs.length;
    this.hasErrors ||= frames.errors !== null;
    this.version++;
  }

  private mergeRow(row: number, { own, other }: RowPair, old: ReturnType<typeof columns>, frames: Frames, states: Uint8Array | null): void {
    const d = this.data;
    if (own >= 0 && d !== old) {
      for (const key of Object.keys(d) as (keyof typeof d)[]) {
        const { width } = d[key];
        d[key].set(row, ...old[key].view(own + 1).subarray(own * width));
      }
    }
    if (other < 0) return;
    const three = (values: Float32Array) => values.subarray(3 * other, 3 * other + 3);
    d.positions.set(row, ...three(frames.positions));
    d.orientations.set(row, ...frames.orientations.subarray(4 * other, 4 * other + 4));
    d.errors.set(row, frames.errors?.[other] ?? NaN);
    if (frames.sigmas) d.sigmas.set(row, frames.sigmas[other]);
    if (own >= 0) return;
    d.stamps.set(row, frames.stamps[other]);
    d.online.set(row, ...(frames.online ? three(frames.online) : [NaN, NaN, NaN]));
    d.states.set(row, states?.[other] ?? 0);
    d.milliseconds.set(row, frames.milliseconds?.[other] ?? NaN);
    if (!frames.sigmas) d.sigmas.set(row, NaN);
  }

  /** States of a scene by this record's names. */
  private translated(states: Uint8Array, names: string[]): Uint8Array {
    const to = names.map((name) => {
      const known = this.stateNames.indexOf(name);
      return known >= 0 ? known : this.stateNames.push(name) - 1;
    });
    return states.map((s) => to[s]);
  }

  /** A change to a state that is worth a mark is an event, also where the run sends none. */
  private noteEvents(frame: LiveFrame, row: number): void {
    const name = this.stateNames[frame.state];
    const before = row > 0 ? this.data.states.view(row)[row - 1] : -1;
    const events = [...frame.events];
    const told = events.some((e) => e.kind === name);
    if (before !== frame.state && (badStates.includes(name) || row > 0) && !told) {
      events.push({ kind: name, detail: frame.detail || frame.reason });
    }
    const marked = events.filter((e) => isMarked(e.kind) || this.stateNames.includes(e.kind));
    this.events.push(...marked.map((e) => eventOf(frame, e)));
  }
}
