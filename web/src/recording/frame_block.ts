// SPDX-License-Identifier: Apache-2.0
// Reads the block of one frame of a recording. Nothing in it may be believed: a bad one throws SceneError and nothing else.
import { readBlock } from '../scene/parse';
import { SceneError } from '../scene/scene';
import { readFeatures, type LiveImage } from '../live/messages';

export interface RecordedFrame {
  index: number;
  name: string;
  /** Null: the frame has none. */
  image: LiveImage | null;
  /** In the frame of the camera, or of the body of a laser. */
  points: Float32Array;
  /** Of each point; null: unknown. */
  colors: Uint8Array | null;
}

const mostPoints = 1e6;

export function readFrameBlock(bytes: Uint8Array): RecordedFrame {
  const entry = readBlock(bytes, 'frame');
  if (entry.text('type') !== 'frame') throw new SceneError('the server sent no frame');
  const index = entry.index('index', 2 ** 31);
  const points = entry.arrayOrNull('points', 'f32', 3, null) ?? new Float32Array(0);
  if (points.length > 3 * mostPoints) throw entry.error('points', `has ${points.length / 3} points`);
  const jpeg = entry.arrayOrNull('jpeg', 'u8', 1, null);
  const side = (key: string) => Math.min(65535, entry.positive(key));
  return {
    index, name: entry.text('name', ''), points, colors: points.length ? entry.arrayOrNull('colors', 'u8', 3, points.length / 3) : null,
    image: jpeg && { type: 'image', index, width: side('width'), height: side('height'), jpeg, ...readFeatures(entry) },
  };
}
