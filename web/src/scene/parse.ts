// SPDX-License-Identifier: Apache-2.0
// Reads a scene: uint32 length of the header, header (JSON), body. Throws SceneError and nothing else.
import { Entry, checkIndices } from './header';
import { parseLayer } from './parse_layers';
import {
  SceneError,
  type Camera,
  type Frames,
  type Keyframes,
  type NamedLength,
  type Scale,
  type Scene,
  type SceneEvent,
  type Session,
  type Thumbnail,
  type Vec3,
} from './scene';

const defaultStates = ['tracking', 'weak', 'lost', 'relocalized', 'initializing'];

export function parseScene(bytes: Uint8Array): Scene {
  const header = readBlock(bytes, '');
  if (header.text('format') !== 'rastro-scene') throw new SceneError('this is not a scene of rastro');
  if (header.number('version') !== 1) {
    throw new SceneError(`the scene has version ${header.number('version')}, this page reads version 1`);
  }
  const keyframes = parseKeyframes(header.child('keyframes'));
  const frames = parseFrames(header.child('frames'));
  const stateNames = parseStateNames(header);
  if (frames?.states) checkIndices(frames.states, stateNames.length, 'frames.states');
  return {
    title: header.text('title', ''),
    method: header.text('method', ''),
    revision: header.numberOrNull('revision'),
    scale: parseScale(header.child('scale')),
    up: parseUp(header),
    planar: header.flag('planar'),
    sessions: header.children('sessions').map(parseSession),
    frames,
    stateNames,
    events: header.children('events').map((e) => parseEvent(e, frames)).sort((a, b) => a.stamp - b.stamp),
    keyframes,
    camera: parseCamera(header.child('camera')),
    layers: header.children('layers').map((e) => parseLayer(e, keyframes?.count ?? 0)),
    lengths: header.children('lengths').map(parseLength),
    images: header.children('images').map((e) => parseImage(e, keyframes?.count ?? 0)),
  };
}

/** A block of bytes with a header; the messages of a run with binary parts are laid out like scenes. */
export function readBlock(bytes: Uint8Array, where: string): Entry {
  const what = where || 'scene';
  if (bytes.length < 8) throw new SceneError(`the ${what} has only ${bytes.length} bytes`);
  const length = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
  if (4 + length > bytes.length) throw new SceneError(`the header of the ${what} is cut off`);
  if ((4 + length) % 8 !== 0) throw new SceneError(`the header of the ${what} has a wrong length`);
  let json: unknown;
  try {
    json = JSON.parse(new TextDecoder('utf-8', { fatal: true }).decode(bytes.subarray(4, 4 + length)));
  } catch {
    throw new SceneError(`the header of the ${what} is not readable JSON`);
  }
  return Entry.from(json, alignedBody(bytes, 4 + length), where);
}

/** Typed arrays need a body that starts at a multiple of 8 in its buffer; only an unaligned scene is copied. */
function alignedBody(bytes: Uint8Array, start: number): Uint8Array<ArrayBuffer> {
  const body = bytes.subarray(start);
  const usable = body.byteOffset % 8 === 0 && body.buffer instanceof ArrayBuffer;
  return usable ? (body as Uint8Array<ArrayBuffer>) : new Uint8Array(body);
}

function parseStateNames(header: Entry): string[] {
  const names = header.value('state_names') ?? defaultStates;
  if (!Array.isArray(names) || !names.every((n) => typeof n === 'string')) {
    throw header.error('state_names', 'is not a list of texts');
  }
  return names;
}

function parseScale(entry: Entry | null): Scale {
  if (!entry) return { kind: 'metric', sigma: null, origin: '' };
  const kind = entry.text('kind');
  if (kind !== 'metric' && kind !== 'arbitrary') throw entry.error('kind', `is ${kind}, not metric or arbitrary`);
  return { kind, sigma: entry.numberOrNull('sigma'), origin: entry.text('origin', '') };
}

function parseUp(header: Entry): Vec3 {
  if (!header.has('up')) return [0, 0, 1];
  const up = header.vec3('up');
  const norm = Math.hypot(...up);
  if (!(norm > 1e-6) || !Number.isFinite(norm)) throw header.error('up', 'has no direction');
  return [up[0] / norm, up[1] / norm, up[2] / norm];
}

function parseSession(entry: Entry): Session {
  return {
    id: entry.number('id'),
    robot: entry.numberOrNull('robot') ?? 0,
    name: entry.text('name', ''),
    first: entry.numberOrNull('first') ?? 0,
    last: entry.numberOrNull('last') ?? 0,
  };
}

function parseFrames(entry: Entry | null): Frames | null {
  if (!entry) return null;
  const stamps = entry.array('stamps', 'f64', 1, null);
  const count = stamps.length;
  if (count === 0) return null;
  checkStamps(stamps, 'frames.stamps');
  return {
    count,
    stamps,
    positions: entry.array('positions', 'f32', 3, count),
    orientations: entry.array('orientations', 'f32', 4, count),
    online: entry.arrayOrNull('online', 'f32', 3, count),
    states: entry.arrayOrNull('states', 'u8', 1, count),
    sigmas: entry.arrayOrNull('sigmas', 'f32', 1, count),
    errors: entry.arrayOrNull('errors', 'f32', 1, count),
    truth: entry.arrayOrNull('truth', 'f32', 3, count),
    milliseconds: entry.arrayOrNull('milliseconds', 'f32', 1, count),
  };
}

/** The timeline searches in the stamps, so they must be finite and must not go back. */
function checkStamps(stamps: Float64Array, where: string): void {
  for (let i = 0; i < stamps.length; i++) {
    if (!Number.isFinite(stamps[i])) throw new SceneError(`${where}[${i}] is not a number`);
    if (i > 0 && stamps[i] < stamps[i - 1]) throw new SceneError(`${where}[${i}] is before the stamp in front of it`);
  }
}

function parseEvent(entry: Entry, frames: Frames | null): SceneEvent {
  const frame = entry.numberOrNull('frame');
  const known = frame !== null && Number.isInteger(frame) && frame >= 0 && frame < (frames?.count ?? 0);
  const stamp = entry.numberOrNull('stamp') ?? (known ? frames!.stamps[frame] : 0);
  return { frame: known ? frame : null, stamp, kind: entry.text('kind'), detail: entry.text('detail', '') };
}

function parseKeyframes(entry: Entry | null): Keyframes | null {
  if (!entry) return null;
  const ids = entry.array('ids', 'i32', 1, null);
  const count = ids.length;
  if (count === 0) return null;
  return {
    count,
    ids,
    stamps: entry.array('stamps', 'f64', 1, count),
    poses: entry.array('poses', 'f32', 7, count),
    sessions: entry.arrayOrNull('sessions', 'i32', 1, count),
    submaps: entry.arrayOrNull('submaps', 'i32', 1, count),
  };
}

function parseCamera(entry: Entry | null): Camera | null {
  if (!entry) return null;
  return {
    width: entry.positive('width'),
    height: entry.positive('height'),
    fx: entry.positive('fx'),
    fy: entry.positive('fy'),
    cx: entry.number('cx'),
    cy: entry.number('cy'),
  };
}

function parseLength(e: Entry): NamedLength {
  return { name: e.text('name', ''), a: e.vec3('a'), b: e.vec3('b'), length: e.number('length'), sigma: e.numberOrNull('sigma') };
}

function parseImage(entry: Entry, keyframes: number): Thumbnail {
  return {
    keyframe: entry.index('keyframe', keyframes),
    width: entry.positive('width'),
    height: entry.positive('height'),
    jpeg: entry.array('jpeg', 'u8', 1, null),
  };
}
