// SPDX-License-Identifier: Apache-2.0
// A scripted run: its messages, images and maps.
import type { Page } from 'playwright-core';
import { SceneWriter, random } from './scene_writer';
import { stateNames } from './scenes';

export const allCommands = ['pause', 'resume', 'step', 'mapping_on', 'mapping_off', 'reset', 'save', 'end'];
export const featureNames = ['unmatched', 'matched', 'outlier', 'inlier', 'new'];

export function hello(options: object = {}): object {
  return { type: 'hello', version: 1, title: 'corridor', method: 'orb', state_names: stateNames, frames: 240, commands: allCommands, ...options };
}

export function status(options: object = {}): object {
  return { type: 'status', paused: false, mapping: true, ended: false, line: '', ...options };
}

/** Of boards that were not seen in the upper and lower left of the image. */
export function coverage(options: object = {}): object {
  const seen = Array.from({ length: 36 }, (_, k) => (k % 6 >= 2 ? 1 : 0));
  return { name: '', seen, missing: [1, 0, 0, 0, 0, 0, 1, 0, 0], tilts: [23.2, 0, 4, 8.4], ...options };
}

export function calibration(options: object = {}): object {
  return {
    type: 'calibration', line: 'hold the board in the lower left of the image', views: 7, enough_views: 20, enough: false, wanted_tilt: 15,
    missing: ['lower left', 'upper left', 'boards tilted up or down'], cameras: [coverage()], outlines: [[300, 100, 500, 110, 490, 250, 310, 240]], ...options,
  };
}

/** Pose on a circle of 2 m around the origin; y points down. */
export function poseAt(i: number): number[] {
  const angle = (i / 120) * Math.PI;
  return [2 * Math.sin(angle), -0.1 * Math.sin(3 * angle), -2 * Math.cos(angle), 0, Math.sin(-angle / 2 + Math.PI / 2), 0, Math.cos(-angle / 2 + Math.PI / 2)];
}

export function frame(index: number, options: object = {}): Record<string, unknown> {
  const busy = 1 + 0.3 * Math.sin(index / 5);
  return {
    type: 'frame', index, stamp: 100 + index / 30, state: 0, reason: 'none', detail: '', pose: poseAt(index), sigma: 0.008, used: 180 + (index % 30), score: 0.82,
    ms: 14.2 * busy, stages: { features: 6.1 * busy, matching: 3.4, pose: 1.9 * busy, local_map: 2.1, place_recognition: 0.4 }, events: [],
    done: index + 1, rate: 43.1, memory_mb: 131, dropped: 0, ...options,
  };
}

/** Frame of a lost stretch, with what to do. */
export function lostFrame(index: number): object {
  return frame(index, {
    state: 2, pose: null, sigma: null, used: 7, reason: 'too_few_matches', detail: '7 matches with the map, at least 20 needed',
    advice: 'Point the camera back at a part that was mapped, or move more slowly.',
  });
}

export interface ImageOptions {
  jpeg: Uint8Array;
  features?: number[];
  states?: number[];
  width?: number;
  height?: number;
  /** Of each feature, and where it was before. */
  ids?: number[];
  trails?: number[][];
  colors?: number[];
  names?: string[];
}

export function image(index: number, options: ImageOptions): Uint8Array {
  const w = new SceneWriter();
  return w.finish({ type: 'image', ...imageFields(w, index, options) });
}

export function place(index: number, keyframe: number, own: ImageOptions, matched?: ImageOptions): Uint8Array {
  const w = new SceneWriter();
  return w.finish({ type: 'place', keyframe, ...imageFields(w, index, own), ...(matched ? { matched: { keyframe: 12, ...imageFields(w, 40, matched) } } : {}) });
}

function imageFields(w: SceneWriter, index: number, options: ImageOptions): object {
  const { features = [], states = [], width = 640, height = 480 } = options;
  return {
    index, width, height, jpeg: w.u8(options.jpeg), features: w.f32(features), feature_states: w.u8(states), feature_state_names: options.names ?? featureNames,
    ...(options.ids ? { feature_ids: w.i32(options.ids) } : {}),
    ...(options.trails ? { trail_lengths: w.u8(options.trails.map((t) => t.length / 2)), trails: w.f32(options.trails.flat()) } : {}),
    ...(options.colors ? { feature_colors: w.u8(options.colors) } : {}),
  };
}

/** Features as a frontend spreads them over an image. */
export function manyFeatures(count: number, seed: number): { features: number[]; states: number[] } {
  const rnd = random(seed);
  const features = Array.from({ length: 2 * count }, (_, i) => (i % 2 ? 20 + 440 * rnd() : 20 + 600 * rnd()));
  return { features, states: Array.from({ length: count }, () => [0, 0, 1, 2, 3, 3, 3, 3, 4][Math.floor(rnd() * 9)]) };
}

/** The map after `keyframes` keyframes, every tenth frame one; `shift` as if a loop had moved it. */
export function mapScene(revision: number, keyframes: number, shift = 0, options: object = {}): Uint8Array {
  const w = new SceneWriter();
  const rnd = random(3);
  const count = 100 * keyframes;
  const positions = Array.from({ length: count }, (_, i) => {
    const p = poseAt((i * 10) / 100);
    return [2 * p[0] + 0.3 * rnd() + shift, 1.2 - 2 * rnd(), 2 * p[2] + 0.3 * rnd()];
  }).flat();
  const rows = Array.from({ length: keyframes }, (_, i) => i);
  const frames = Array.from({ length: 10 * (keyframes - 1) + 1 }, (_, i) => i);
  const moved = (i: number) => [poseAt(i)[0] + shift, ...poseAt(i).slice(1)];
  return w.finish({
    title: 'corridor', method: 'orb', revision, up: [0, -1, 0], state_names: stateNames, scale: { kind: 'arbitrary' },
    camera: { width: 640, height: 480, fx: 525, fy: 525, cx: 319.5, cy: 239.5 },
    keyframes: { ids: w.i32(rows), stamps: w.f64(rows.map((i) => 100 + i / 3)), poses: w.f32(rows.flatMap((i) => moved(10 * i))) },
    frames: { stamps: w.f64(frames.map((i) => 100 + i / 30)), positions: w.f32(frames.flatMap((i) => moved(i).slice(0, 3))), orientations: w.f32(frames.flatMap((i) => moved(i).slice(3))) },
    events: [], layers: [
      { kind: 'edges', name: 'covisibility', pairs: w.u32(rows.slice(1).flatMap((i) => [i - 1, i])) },
      { kind: 'points', name: 'landmarks', positions: w.f32(positions), keyframes: w.u32(Array.from({ length: count }, (_, i) => Math.floor(i / 100))) },
    ],
    ...options,
  });
}

/** A corridor as a JPEG file, drawn by the browser. */
export async function corridorJpeg(page: Page, width: number, height: number, seed = 0): Promise<Buffer> {
  const base64 = await page.evaluate(([w, h, s]) => {
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [w, h];
    const context = canvas.getContext('2d')!;
    for (let i = 0; i < 12; i++) {
      const share = 1 - i / 12;
      context.fillStyle = `rgb(${60 + 11 * i}, ${58 + 10 * i}, ${54 + 9 * i})`;
      context.fillRect((w / 2) * (1 - share) + 12 * s, (h / 2) * (1 - share), w * share, h * share);
      context.strokeStyle = '#303030';
      context.strokeRect((w / 2) * (1 - share) + 12 * s, (h / 2) * (1 - share), w * share, h * share);
    }
    return canvas.toDataURL('image/jpeg', 0.8).split(',')[1];
  }, [width, height, seed]);
  return Buffer.from(base64, 'base64');
}

/** One color as a JPEG file. */
export async function plainJpeg(page: Page, color: string, width = 320, height = 240): Promise<Buffer> {
  const base64 = await page.evaluate(([c, w, h]) => {
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [Number(w), Number(h)];
    const context = canvas.getContext('2d')!;
    context.fillStyle = c;
    context.fillRect(0, 0, canvas.width, canvas.height);
    return canvas.toDataURL('image/jpeg', 0.95).split(',')[1];
  }, [color, `${width}`, `${height}`]);
  return Buffer.from(base64, 'base64');
}
