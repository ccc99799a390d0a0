// SPDX-License-Identifier: Apache-2.0
// Brings two lists of stamps together.
import type { SceneEvent } from '../scene/scene';

export interface RowPair {
  /** Rows of one frame in either list, -1 where it is missing. */
  own: number;
  other: number;
}

/** Stamps go through text on one way and not on the other. */
const same = 1e-6;

/** Both lists by time; frames of one stamp are one row. */
export function mergedRows(own: Float64Array, other: Float64Array): RowPair[] {
  const rows: RowPair[] = [];
  for (let i = 0, j = 0; i < own.length || j < other.length;) {
    const [a, b] = [i < own.length ? own[i] : Infinity, j < other.length ? other[j] : Infinity];
    if (Math.abs(a - b) <= same) rows.push({ own: i++, other: j++ });
    else if (a < b) rows.push({ own: i++, other: -1 });
    else rows.push({ own: -1, other: j++ });
  }
  return rows;
}

/** Events of both, by time; one kind at one time is one event. */
export function mergedEvents(own: SceneEvent[], other: SceneEvent[]): SceneEvent[] {
  const key = (e: SceneEvent) => `${e.kind} ${e.stamp.toFixed(4)}`;
  const known = new Set(own.map(key));
  return [...own, ...other.filter((e) => !known.has(key(e))).map((e) => ({ ...e, frame: null }))].sort((a, b) => a.stamp - b.stamp);
}
