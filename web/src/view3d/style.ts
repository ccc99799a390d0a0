// SPDX-License-Identifier: Apache-2.0
// How layers are drawn, and what every layer offers to the page.
import type * as THREE from 'three';
import type { Vec3 } from '../scene/scene';
import type { MapName, Range } from './colors';

export type PointColor = 'image' | 'height' | 'age' | 'uncertainty' | 'run';
export type TrajectoryColor = 'state' | 'error' | 'sigma' | 'time' | 'run';
export type RangeName = 'height' | 'age' | 'uncertainty' | 'error' | 'sigma' | 'time';

export interface Style {
  pointColor: PointColor;
  trajectoryColor: TrajectoryColor;
  map: MapName;
  /** Diameter of a point in pixels of the page. */
  pointSize: number;
  /** Points with a larger sigma are hidden; Infinity shows all. */
  maxSigma: number;
  /** Depth of a drawn camera in the scene's unit. */
  cameraSize: number;
  /** Ellipsoids are drawn at this many sigmas. */
  ellipsoidScale: number;
  dark: boolean;
  up: Vec3;
  /** Shared by all runs, so that one color means one value. */
  ranges: Record<RangeName, Range | null>;
}

export interface LayerObject {
  /** Same in every run and every visit of the page: it stands in the URL. */
  key: string;
  label: string;
  /** What it holds, such as "1,204 points". */
  detail: string;
  object: THREE.Object3D;
  shownAtFirst: boolean;
  applyStyle(style: Style): void;
}

/** Objects with points are drawn in slices over several pictures; they lie in this layer of three.js. */
export const pointsMask = 1;

export function count(n: number, one: string, many = `${one}s`): string {
  return `${n.toLocaleString('en-US')} ${n === 1 ? one : many}`;
}

/** "essential_graph" as a person reads it: "Essential graph". */
export function titled(name: string): string {
  const words = name.replace(/[_-]+/g, ' ').trim();
  return words.charAt(0).toUpperCase() + words.slice(1);
}
