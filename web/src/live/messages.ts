// SPDX-License-Identifier: Apache-2.0
// Reads the messages of a run. Nothing in them may be believed: each is checked, a bad one throws SceneError and nothing else.
import { Entry } from '../scene/header';
import { readBlock } from '../scene/parse';
import { SceneError, type SceneEvent } from '../scene/scene';

export const commands = ['pause', 'resume', 'step', 'mapping_on', 'mapping_off', 'reset', 'save', 'end'] as const;
export type Command = (typeof commands)[number];

export interface Hello {
  type: 'hello';
  title: string;
  method: string;
  stateNames: string[];
  /** Frames of the whole run, null where that is not known (a camera). */
  frames: number | null;
  commands: Set<Command>;
  /** False: the run estimates none, its images are all there is to see. */
  poses: boolean;
}

export interface LiveFrame {
  type: 'frame';
  index: number;
  stamp: number;
  state: number;
  reason: string;
  detail: string;
  advice: string;
  /** x y z qx qy qz qw, world_from_camera or body; null while the pose is not known. */
  pose: number[] | null;
  sigma: number | null;
  used: number | null;
  score: number | null;
  ms: number | null;
  stages: [string, number][];
  events: { kind: string; detail: string }[];
  done: number | null;
  rate: number | null;
  memoryMb: number | null;
  dropped: number;
}

export interface SceneNews {
  type: 'scene';
  index: number;
  revision: number | null;
}

export interface Status {
  type: 'status';
  paused: boolean | null;
  mapping: boolean | null;
  ended: boolean;
  line: string;
  /** How often the run began anew. */
  resets: number;
}

export interface LiveImage {
  type: 'image';
  index: number;
  /** Of the full image, to which the features refer. */
  width: number;
  height: number;
  jpeg: Uint8Array;
  features: Float32Array;
  states: Uint8Array;
  stateNames: string[];
  /** Of each feature, the same in all images, -1 where it has none; null: unknown. */
  ids: Int32Array | null;
  /** Of each feature: where it was in the last frames, x and y, the oldest first; empty: unknown. */
  trails: Float32Array[];
  /** Red, green and blue of each feature; null: each state has its own. */
  colors: Uint8Array | null;
}

/** A keyframe as the map knows it, and the earlier one that it was matched with. */
export interface LivePlace {
  type: 'place';
  /** -1: a frame that is none. */
  keyframe: number;
  image: LiveImage;
  matched: { keyframe: number; image: LiveImage } | null;
}

/** What the boards so far have shown to one camera. */
export interface Coverage {
  /** Empty where there is one camera. */
  name: string;
  /** Of cells of its image, row by row, as many along a row as rows: whether they had a corner. */
  seen: boolean[];
  /** Of larger parts: whether the board is wanted there. */
  missing: boolean[];
  /** Largest tilts in degrees: left, right, up, down. */
  tilts: number[];
}

/** A calibration that goes on. Images of a pair are side by side in one. */
export interface Calibration {
  type: 'calibration';
  /** What to do next. */
  line: string;
  views: number;
  enoughViews: number;
  enough: boolean;
  wantedTilt: number;
  missing: string[];
  cameras: Coverage[];
  /** Of each board taken, pixels of the image. */
  outlines: number[][];
}

export type Message = Hello | LiveFrame | SceneNews | Status | Calibration;

const noBody = new Uint8Array(0);
const largestIndex = 2 ** 31;
const latestStamp = 1e11;
const longestText = 1e6;
const mostFeatures = 200000;

/** Null: a kind of message that this page does not know, from a newer program. */
export function readText(text: string, states: number): Message | null {
  if (text.length > longestText) throw new SceneError(`a message has ${text.length} characters`);
  let json: unknown;
  try {
    json = JSON.parse(text);
  } catch {
    throw new SceneError('a message is not readable JSON');
  }
  const entry = Entry.from(json, noBody, 'message');
  switch (entry.text('type')) {
    case 'hello':
      return readHello(entry);
    case 'frame':
      return readFrame(entry, states);
    case 'scene':
      return { type: 'scene', index: entry.index('index', largestIndex), revision: entry.numberOrNull('revision') };
    case 'status':
      return readStatus(entry);
    case 'calibration':
      return readCalibration(entry);
    default:
      return null;
  }
}

function readHello(entry: Entry): Hello {
  if (entry.number('version') !== 1) throw new SceneError(`the run speaks version ${entry.number('version')}, this page version 1`);
  const stateNames = texts(entry, 'state_names', 255);
  if (stateNames.length === 0) throw entry.error('state_names', 'is empty');
  const known = texts(entry, 'commands', 100).filter((c): c is Command => (commands as readonly string[]).includes(c));
  return {
    type: 'hello', title: entry.text('title', ''), method: entry.text('method', ''), stateNames,
    frames: entry.numberOrNull('frames'), commands: new Set(known), poses: !entry.has('poses') || entry.flag('poses'),
  };
}

function readFrame(entry: Entry, states: number): LiveFrame {
  return {
    type: 'frame',
    index: entry.index('index', largestIndex),
    stamp: stampOf(entry),
    state: entry.index('state', states),
    reason: entry.text('reason', ''),
    detail: entry.text('detail', ''),
    advice: entry.text('advice', ''),
    pose: entry.has('pose') ? entry.numbers('pose', 7) : null,
    sigma: entry.numberOrNull('sigma'),
    used: entry.numberOrNull('used'),
    score: entry.numberOrNull('score'),
    ms: entry.numberOrNull('ms'),
    stages: readStages(entry),
    events: entry.children('events').slice(0, 100).map((e) => ({ kind: e.text('kind'), detail: e.text('detail', '') })),
    done: entry.numberOrNull('done'),
    rate: entry.numberOrNull('rate'),
    memoryMb: entry.numberOrNull('memory_mb'),
    dropped: entry.numberOrNull('dropped') ?? 0,
  };
}

/** A time far beyond any clock would stretch the timeline until nothing is left of the run. */
function stampOf(entry: Entry): number {
  const stamp = entry.number('stamp');
  if (Math.abs(stamp) > latestStamp) throw entry.error('stamp', `is ${stamp}, not a time in seconds`);
  return stamp;
}

function readStages(entry: Entry): [string, number][] {
  const stages = entry.value('stages') ?? {};
  if (typeof stages !== 'object' || Array.isArray(stages)) throw entry.error('stages', 'is not an object');
  const known = Object.entries(stages as object).filter((e): e is [string, number] => Number.isFinite(e[1]) && e[1] >= 0);
  return known.slice(0, 24).map(([name, ms]) => [name.slice(0, 60), ms]);
}

function readStatus(entry: Entry): Status {
  const flag = (key: string) => (entry.has(key) ? entry.flag(key) : null);
  return { type: 'status', paused: flag('paused'), mapping: flag('mapping'), ended: entry.flag('ended'), line: entry.text('line', ''), resets: entry.numberOrNull('resets') ?? 0 };
}

function readCalibration(entry: Entry): Calibration {
  return {
    type: 'calibration', line: entry.text('line', ''), views: entry.index('views', largestIndex), enoughViews: entry.index('enough_views', largestIndex),
    enough: entry.flag('enough'), wantedTilt: entry.positive('wanted_tilt'), missing: texts(entry, 'missing', 60),
    cameras: entry.children('cameras').slice(0, 2).map(readCoverage),
    outlines: listOf(entry, 'outlines', 4000).map((outline) => numbersIn(entry, 'outlines', outline, 400)),
  };
}

function readCoverage(entry: Entry): Coverage {
  return {
    name: entry.text('name', ''), seen: square(entry, 'seen'), missing: square(entry, 'missing'), tilts: entry.numbers('tilts', 4),
  };
}

/** Cells of a square, row by row. */
function square(entry: Entry, key: string): boolean[] {
  const cells = numbersIn(entry, key, entry.value(key), 400);
  if (cells.length === 0 || !Number.isInteger(Math.sqrt(cells.length))) throw entry.error(key, `has ${cells.length} cells`);
  return cells.map((cell) => cell === 1);
}

function listOf(entry: Entry, key: string, most: number): unknown[] {
  const list = entry.value(key);
  if (!Array.isArray(list) || list.length > most) throw entry.error(key, 'is not a list');
  return list;
}

function numbersIn(entry: Entry, key: string, list: unknown, most: number): number[] {
  if (!Array.isArray(list) || list.length > most || !list.every((n) => Number.isFinite(n))) throw entry.error(key, 'is not a list of numbers');
  return list as number[];
}

function texts(entry: Entry, key: string, most: number): string[] {
  const list = entry.value(key);
  if (!Array.isArray(list) || list.length > most || !list.every((t) => typeof t === 'string')) throw entry.error(key, 'is not a list of texts');
  return list.map((t: string) => t.slice(0, 60));
}

/** Null: a kind of block that this page does not know. */
export function readBinary(bytes: Uint8Array): LiveImage | LivePlace | null {
  const entry = readBlock(bytes, 'message');
  switch (entry.text('type')) {
    case 'image':
      return readImage(entry);
    case 'place':
      return readPlace(entry);
    default:
      return null;
  }
}

function readPlace(entry: Entry): LivePlace {
  const matched = entry.child('matched');
  return {
    type: 'place', keyframe: entry.number('keyframe'), image: readImage(entry),
    matched: matched && { keyframe: matched.number('keyframe'), image: readImage(matched) },
  };
}

function readImage(entry: Entry): LiveImage {
  return {
    type: 'image', index: entry.index('index', largestIndex), width: side(entry, 'width'), height: side(entry, 'height'),
    jpeg: entry.array('jpeg', 'u8', 1, null), ...readFeatures(entry),
  };
}

/** Of any block with an image. */
export function readFeatures(entry: Entry): Omit<LiveImage, 'type' | 'index' | 'width' | 'height' | 'jpeg'> {
  const features = entry.arrayOrNull('features', 'f32', 2, null) ?? new Float32Array(0);
  const count = features.length / 2;
  if (count > mostFeatures) throw entry.error('features', `has ${count} features`);
  if (count === 0) return { features, states: new Uint8Array(0), stateNames: [], ids: null, trails: [], colors: null };
  return {
    features,
    states: entry.array('feature_states', 'u8', 1, count),
    stateNames: texts(entry, 'feature_state_names', 255),
    ids: entry.arrayOrNull('feature_ids', 'i32', 1, count),
    trails: readTrails(entry, count),
    colors: entry.arrayOrNull('feature_colors', 'u8', 3, count),
  };
}

function readTrails(entry: Entry, features: number): Float32Array[] {
  const lengths = features ? entry.arrayOrNull('trail_lengths', 'u8', 1, features) : null;
  if (!lengths) return [];
  const points = entry.array('trails', 'f32', 2, null);
  let end = 0;
  const trails = Array.from(lengths, (length) => points.subarray(2 * end, 2 * (end += length)));
  if (2 * end !== points.length) throw entry.error('trails', `has ${points.length / 2} points, not ${end}`);
  return trails;
}

function side(entry: Entry, key: string): number {
  const value = entry.positive(key);
  if (value > 65535) throw entry.error(key, `is ${value}, not an image's size`);
  return value;
}

/** An event of a frame as the timeline wants it. */
export function eventOf(frame: { stamp: number }, event: { kind: string; detail: string }): SceneEvent {
  return { frame: null, stamp: frame.stamp, kind: event.kind, detail: event.detail };
}
