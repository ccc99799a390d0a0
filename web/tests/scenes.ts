// SPDX-License-Identifier: Apache-2.0
// Scenes for the tests: a room seen by a camera, a floor seen by a laser, and many points.
import { SceneWriter, random } from './scene_writer';

const camera = { width: 640, height: 480, fx: 525, fy: 525, cx: 319.5, cy: 239.5 };
export const stateNames = ['tracking', 'weak', 'lost', 'relocalized', 'initializing'];

export interface RoomOptions {
  title?: string;
  shift?: number;
  points?: number;
  scale?: object;
  without?: string[];
}

/** Camera on an ellipse around the room's middle that looks outward; the world is that of a camera, y down. */
function orbitPose(angle: number): { position: number[]; orientation: number[] } {
  const position = [1.6 * Math.sin(angle), -0.15 * Math.sin(3 * angle), -1.2 * Math.cos(angle)];
  return { position, orientation: [0, Math.sin((Math.PI - angle) / 2), 0, Math.cos((Math.PI - angle) / 2)] };
}

function framesOf(w: SceneWriter, count: number, shift: number): object {
  const noise = random(5);
  const poses = Array.from({ length: count }, (_, i) => orbitPose((i / (count - 1)) * 2 * Math.PI));
  const positions = poses.flatMap((p) => [p.position[0] + shift, p.position[1], p.position[2]]);
  const drift = (i: number) => 0.12 * Math.sin((i / 3 / count) * Math.PI);
  const states = poses.map((_, i) => (i < 8 ? 4 : i > 150 && i < 165 ? 1 : i >= 165 && i < 180 ? 2 : i >= 180 && i < 184 ? 3 : 0));
  return {
    stamps: w.f64(poses.map((_, i) => 1000 + i / 30)),
    positions: w.f32(positions),
    orientations: w.f32(poses.flatMap((p) => p.orientation)),
    online: w.f32(positions.map((v, i) => v + drift(i))),
    truth: w.f32(positions.map((v) => v + 0.02)),
    states: w.u8(states),
    sigmas: w.f32(poses.map((_, i) => 0.004 + 0.01 * Math.abs(Math.sin(i / 40)) + (states[i] === 2 ? 0.05 : 0))),
    errors: w.f32(poses.map((_, i) => 0.01 + 0.02 * Math.abs(Math.sin(i / 60)) + 0.004 * noise())),
    milliseconds: w.f32(poses.map(() => 12 + 6 * noise())),
  };
}

function keyframesOf(w: SceneWriter, count: number, shift: number): object {
  const poses = Array.from({ length: count }, (_, i) => orbitPose((i / (count - 1)) * 2 * Math.PI));
  return {
    ids: w.i32(poses.map((_, i) => i)),
    stamps: w.f64(poses.map((_, i) => 1000 + (i * 399) / (count - 1) / 30)),
    poses: w.f32(poses.flatMap((p) => [p.position[0] + shift, ...p.position.slice(1), ...p.orientation])),
    sessions: w.i32(poses.map(() => 0)),
    submaps: w.i32(poses.map(() => 0)),
  };
}

/** Points on floor, walls and a table of a room of 6 x 2.6 x 5 m; `y` points down, the floor is at 1.2. */
function roomPoints(count: number, seed: number): { positions: Float32Array; colors: Uint8Array } {
  const rnd = random(seed);
  const positions = new Float32Array(3 * count);
  const colors = new Uint8Array(3 * count);
  for (let i = 0; i < count; i++) {
    const [a, b, side] = [rnd(), rnd(), rnd()];
    const p = side < 0.3 ? [6 * a - 3, 1.2, 5 * b - 2.5]
      : side < 0.5 ? [6 * a - 3, 2.6 * b - 1.4, 2.5]
      : side < 0.65 ? [-3, 2.6 * b - 1.4, 5 * a - 2.5]
      : side < 0.85 ? [3, 2.6 * b - 1.4, 5 * a - 2.5] : [1.2 * a + 0.5, 0.45, 0.8 * b + 1.2];
    positions.set(p, 3 * i);
    const checker = (Math.floor(p[0] * 2) + Math.floor(p[1] * 2 + 0.1) + Math.floor(p[2] * 2)) & 1;
    const base = side < 0.3 ? [150, 120, 90] : side < 0.85 ? [175, 185, 190] : [180, 90, 60];
    colors.set(base.map((c) => c - 40 * checker + 20 * rnd()), 3 * i);
  }
  return { positions, colors };
}

function pointsLayer(w: SceneWriter, count: number, keyframes: number, shift: number): object {
  const rnd = random(2);
  const { positions, colors } = roomPoints(count, 1);
  for (let i = 0; i < count; i++) positions[3 * i] += shift;
  return {
    kind: 'points', name: 'landmarks', positions: w.f32(positions), colors: w.u8(colors),
    sigmas: w.f32(Array.from({ length: count }, () => 0.002 * 30 ** rnd())),
    keyframes: w.u32(Array.from({ length: count }, (_, i) => Math.floor((i * keyframes) / count))),
  };
}

function pairs(count: number, steps: number[]): number[] {
  return steps.flatMap((step) => Array.from({ length: count - step }, (_, i) => [i, i + step]).flat());
}

function surfaces(w: SceneWriter): object[] {
  const cubes = Array.from({ length: 60 }, (_, i) => [-2.4 + 0.2 * (i % 6), 1.1 - 0.2 * Math.floor(i / 12), 1.6 + 0.2 * (Math.floor(i / 6) % 2)]);
  return [
    { kind: 'mesh', name: 'mesh', positions: w.f32([-2, 1.2, -2.2, -1, 1.2, -2.2, -1, 0.2, -2.2, -2, 0.2, -2.2, -1.5, -0.2, -1.9]), triangles: w.u32([0, 1, 2, 0, 2, 3, 3, 2, 4]) },
    { kind: 'cubes', name: 'octree', centers: w.f32(cubes.flat()), sizes: w.f32(cubes.map(() => 0.2)) },
    { kind: 'ellipsoids', name: 'covariances', centers: w.f32([1, 0.3, 1.5, 1.5, 0.3, 1.5]), axes: w.f32([0.03, 0, 0, 0, 0.02, 0, 0, 0, 0.06, 0.05, 0, 0.02, 0, 0.02, 0, -0.01, 0, 0.03]) },
  ];
}

export function roomScene(options: RoomOptions = {}): Uint8Array {
  const w = new SceneWriter();
  const { shift = 0, points = 20000 } = options;
  const keyframes = 40;
  const header: Record<string, unknown> = {
    title: options.title ?? 'room', method: 'rgbd', revision: 12, up: [0, -1, 0], planar: false, camera, state_names: stateNames,
    scale: options.scale ?? { kind: 'metric', sigma: 0.01, origin: 'depth camera' },
    sessions: [{ id: 0, robot: 0, name: 'morning', first: 1000, last: 1013.3 }],
    frames: framesOf(w, 400, shift),
    keyframes: keyframesOf(w, keyframes, shift),
    events: [
      { frame: 165, stamp: 1005.5, kind: 'lost', detail: 'only 9 matches, 20 needed' },
      { frame: 180, stamp: 1006, kind: 'relocalized', detail: 'in keyframe 14' },
      { frame: 395, stamp: 1013.16, kind: 'loop_closed', detail: 'keyframes 39 and 0' },
    ],
    layers: [
      { kind: 'edges', name: 'covisibility', pairs: w.u32(pairs(keyframes, [1, 2, 3, 4])) },
      { kind: 'edges', name: 'spanning_tree', pairs: w.u32(pairs(keyframes, [1])) },
      { kind: 'edges', name: 'loops', pairs: w.u32([39, 0, 38, 1, 20, 2]) },
      pointsLayer(w, points, keyframes, shift),
      ...surfaces(w),
    ],
    lengths: [{ name: 'table', a: [0.5, 0.45, 1.2], b: [1.7, 0.45, 1.2], length: 1.2, sigma: 0.006 }],
  };
  for (const key of options.without ?? []) delete header[key];
  return w.finish(header);
}

/** A floor of rooms as an occupancy grid with a laser's trajectory and scans; z up. */
export function floorScene(): Uint8Array {
  const w = new SceneWriter();
  const [width, height, cell] = [240, 160, 0.05];
  const cells = new Uint8Array(width * height).fill(255);
  const points: number[] = [];
  for (let y = 8; y < 152; y++) {
    for (let x = 8; x < 232; x++) {
      const wall = x < 10 || x > 229 || y < 10 || y > 149 || (x % 74 < 2 && y > 70 && y % 50 > 14) || (Math.abs(y - 70) < 2 && x % 37 > 12);
      cells[y * width + x] = wall ? 230 : 12;
      if (wall) points.push(-6 + (x + 0.5) * cell, -4 + (y + 0.5) * cell, 0);
    }
  }
  const path = Array.from({ length: 200 }, (_, i) => [-5 + i * 0.05, -2.2 + 0.5 * Math.sin(i / 18), Math.atan2(0.5 * Math.cos(i / 18) / 18, 0.05)]);
  const pose = (p: number[]) => [p[0], p[1], 0, 0, 0, Math.sin(p[2] / 2), Math.cos(p[2] / 2)];
  const rows = path.filter((_, i) => i % 10 === 0);
  return w.finish({
    title: 'floor', method: 'cartographer', revision: 3, up: [0, 0, 1], planar: true, scale: { kind: 'metric', origin: 'laser' },
    sessions: [], events: [], state_names: stateNames,
    frames: {
      stamps: w.f64(path.map((_, i) => i / 10)), positions: w.f32(path.flatMap((p) => [p[0], p[1], 0])),
      orientations: w.f32(path.flatMap((p) => pose(p).slice(3))), states: w.u8(path.map(() => 0)),
    },
    keyframes: { ids: w.i32(rows.map((_, i) => i)), stamps: w.f64(rows.map((_, i) => i)), poses: w.f32(rows.flatMap(pose)) },
    layers: [
      { kind: 'grid', name: 'grid', width, height, cell, origin: [-6, -4], cells: w.u8(cells) },
      { kind: 'points', name: 'scans', positions: w.f32(points) },
      { kind: 'edges', name: 'constraints', pairs: w.u32(pairs(rows.length, [1])) },
    ],
  });
}

/** Few points at known places with known sigmas. */
export function exactScene(scale: object = { kind: 'metric' }): Uint8Array {
  const w = new SceneWriter();
  const positions = [0, 0, 0, 1, 0, 0, 1, 2, 0, 0, 2, 0, 0.5, 1, 0.75];
  return w.finish({
    title: 'exact', method: 'test', up: [0, 0, 1], planar: false, scale, sessions: [], events: [], lengths: [],
    layers: [{ kind: 'points', name: 'cloud', positions: w.f32(positions), sigmas: w.f32([0.003, 0.004, 0.01, 0.02, 0.05]), colors: w.u8([255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 0, 255, 0, 255, 255]) }],
  });
}

/** A board of 0.75 by 0.3 m, 0.4 m in front of a wall, as noisy points 12 mm apart. */
export function shelfScene(): Uint8Array {
  const w = new SceneWriter();
  const noise = random(3);
  const [positions, colors]: number[][] = [[], []];
  const add = (x: number, y: number, z: number, color: number[]) => {
    positions.push(x, y, z + 0.004 * (noise() - 0.5));
    colors.push(...color);
  };
  for (let x = 0; x <= 0.751; x += 0.0125) for (let y = 0; y <= 0.301; y += 0.0125) add(x, y, 0, [200, 160, 90]);
  for (let x = -0.5; x <= 1.25; x += 0.02) for (let y = -0.5; y <= 0.8; y += 0.02) add(x, y, 0.4, [90, 110, 130]);
  return w.finish({
    title: 'shelf', method: 'test', up: [0, -1, 0], scale: { kind: 'metric' },
    layers: [{ kind: 'points', name: 'cloud', positions: w.f32(positions), colors: w.u8(colors) }],
  });
}

export function cloudScene(count: number): Uint8Array {
  const w = new SceneWriter();
  const { positions, colors } = roomPoints(count, 9);
  return w.finish({
    title: 'many points', method: 'lsd', up: [0, -1, 0], scale: { kind: 'arbitrary' },
    layers: [{ kind: 'points', name: 'semi_dense', positions: w.f32(positions), colors: w.u8(colors), sigmas: w.f32(new Float32Array(count).fill(0.01)) }],
  });
}

/** All kinds of parts, each without content, and frames whose poses are not numbers. */
export function hollowScene(): Uint8Array {
  const w = new SceneWriter();
  const none = w.f32([]);
  const bad = [NaN, Infinity, 3e38];
  return w.finish({
    title: 'hollow', camera, state_names: stateNames,
    frames: { stamps: w.f64([0, 1, 2]), positions: w.f32([...bad, ...bad, ...bad]), orientations: w.f32(new Array(12).fill(NaN)), errors: w.f32(bad), sigmas: w.f32(bad) },
    keyframes: { ids: w.i32([0, 1]), stamps: w.f64([NaN, 1]), poses: w.f32(new Array(14).fill(3e38)) },
    layers: [
      { kind: 'edges', name: 'loops', pairs: w.u32([0, 1]) }, { kind: 'edges', name: 'odometry', pairs: w.u32([]) },
      { kind: 'points', name: 'cloud', positions: none, colors: w.u8([]), sigmas: none }, { kind: 'mesh', name: 'mesh', positions: none, triangles: w.u32([]) },
      { kind: 'cubes', name: 'octree', centers: none, sizes: none }, { kind: 'grid', name: 'grid', width: 0, height: 0, cell: 1, origin: [0, 0], cells: w.u8([]) },
      { kind: 'ellipsoids', name: 'covariances', centers: none, axes: none },
    ],
  });
}

/** Two keyframes with an image each. */
export function imagesScene(jpegs: Uint8Array[]): Uint8Array {
  const w = new SceneWriter();
  const poses = [0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 1];
  return w.finish({
    title: 'images', camera,
    frames: { stamps: w.f64([0, 1]), positions: w.f32([0, 0, 0, 1, 0, 0]), orientations: w.f32([0, 0, 0, 1, 0, 0, 0, 1]) },
    keyframes: { ids: w.i32([0, 1]), stamps: w.f64([0, 1]), poses: w.f32(poses) },
    images: jpegs.map((jpeg, keyframe) => ({ keyframe, width: 300, height: 150, jpeg: w.u8(jpeg) })),
  });
}
