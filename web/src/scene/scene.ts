// SPDX-License-Identifier: Apache-2.0
// What a scene holds once it is read and checked. Arrays are views into the bytes of the scene, not copies.

export type Vec3 = [number, number, number];

/** A scene that cannot be read; the message is one plain line for the person in front of the page. */
export class SceneError extends Error {
  constructor(message: string) {
    super(message);
    this.name = 'SceneError';
  }
}

export interface Scale {
  kind: 'metric' | 'arbitrary';
  /** Standard deviation of the scale, relative to it (0.01 is one percent). */
  sigma: number | null;
  origin: string;
}

export interface Session {
  id: number;
  robot: number;
  name: string;
  first: number;
  last: number;
}

export interface Frames {
  count: number;
  stamps: Float64Array;
  positions: Float32Array;
  orientations: Float32Array;
  online: Float32Array | null;
  states: Uint8Array | null;
  sigmas: Float32Array | null;
  errors: Float32Array | null;
  truth: Float32Array | null;
  milliseconds: Float32Array | null;
}

export interface SceneEvent {
  /** Row of the frame, or null where the event has no frame with a pose. */
  frame: number | null;
  stamp: number;
  kind: string;
  detail: string;
}

export interface Keyframes {
  count: number;
  ids: Int32Array;
  stamps: Float64Array;
  poses: Float32Array;
  sessions: Int32Array | null;
  submaps: Int32Array | null;
}

export interface Camera {
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
}

export interface EdgesLayer {
  kind: 'edges';
  name: string;
  count: number;
  pairs: Uint32Array;
}

/** An octree over points that are too many to be sent at once; row 0 is the root, whose points are the layer's own arrays. */
export interface TileIndex {
  /** Points of all tiles. */
  count: number;
  /** Center, and half of the edge, of each tile. */
  cubes: Float32Array;
  /** Distance of neighbors in the sample of each tile; 0: nothing finer lies below. */
  spacings: Float32Array;
  parents: Int32Array;
  /** Points of each. */
  counts: Uint32Array;
  /** Its number on the server. */
  layer: number;
  /** Where a tile is fetched from; null: nowhere, as in a file. */
  url: ((row: number) => string) | null;
}

export interface PointsLayer {
  kind: 'points';
  name: string;
  count: number;
  positions: Float32Array;
  colors: Uint8Array | null;
  sigmas: Float32Array | null;
  keyframes: Uint32Array | null;
  /** The points are those of the root alone. */
  tiles: TileIndex | null;
}

export interface MeshLayer {
  kind: 'mesh';
  name: string;
  count: number;
  positions: Float32Array;
  colors: Uint8Array | null;
  triangles: Uint32Array;
}

export interface CubesLayer {
  kind: 'cubes';
  name: string;
  count: number;
  centers: Float32Array;
  sizes: Float32Array;
  colors: Uint8Array | null;
}

export interface GridLayer {
  kind: 'grid';
  name: string;
  count: number;
  width: number;
  height: number;
  cell: number;
  origin: [number, number];
  cells: Uint8Array;
}

export interface EllipsoidsLayer {
  kind: 'ellipsoids';
  name: string;
  count: number;
  centers: Float32Array;
  axes: Float32Array;
}

export type Layer = EdgesLayer | PointsLayer | MeshLayer | CubesLayer | GridLayer | EllipsoidsLayer;

export interface NamedLength {
  name: string;
  a: Vec3;
  b: Vec3;
  length: number;
  sigma: number | null;
}

export interface Thumbnail {
  keyframe: number;
  width: number;
  height: number;
  jpeg: Uint8Array;
}

export interface Scene {
  title: string;
  method: string;
  revision: number | null;
  scale: Scale;
  up: Vec3;
  planar: boolean;
  sessions: Session[];
  frames: Frames | null;
  stateNames: string[];
  events: SceneEvent[];
  keyframes: Keyframes | null;
  camera: Camera | null;
  layers: Layer[];
  lengths: NamedLength[];
  images: Thumbnail[];
}

/** What is shown of a run before its first map. The first camera's axes are the best guess of the world's: y down. */
export function emptyScene(title: string): Scene {
  return {
    title, method: '', revision: null, scale: { kind: 'metric', sigma: null, origin: '' }, up: [0, -1, 0], planar: false, sessions: [],
    frames: null, stateNames: [], events: [], keyframes: null, camera: null, layers: [], lengths: [], images: [],
  };
}
