// SPDX-License-Identifier: Apache-2.0
// Points of one layer as one buffer. They are stored in an order whose every beginning is an even sample of the whole,
// so that a slice can be drawn while the view moves and the rest afterwards.
import * as THREE from 'three';
import type { Keyframes, PointsLayer as PointsData } from '../scene/scene';
import { hexToRgb } from './colors';
import { mapTexture } from './materials';
import { pointsMask, count, titled, type LayerObject, type PointColor, type RangeName, type Style } from './style';

const vertexShader = `
attribute vec4 color;
attribute float sigma;
attribute float age;
uniform int mode;
uniform float size;
uniform float maxSigma;
uniform vec2 range;
uniform vec3 up;
uniform vec3 flatColor;
uniform sampler2D map;
varying vec3 shade;
void main() {
  float value = mode == 1 ? dot(position, up) : mode == 2 ? age : sigma;
  float share = clamp((value - range.x) / max(range.y - range.x, 1e-12), 0.0, 1.0);
  shade = mode == 0 ? color.rgb : mode == 4 ? flatColor : texture2D(map, vec2(share, 0.5)).rgb;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  if (sigma > maxSigma) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = size;
}`;

const fragmentShader = `
uniform float size;
varying vec3 shade;
void main() {
  vec2 p = gl_PointCoord - 0.5;
  if (size > 2.5 && dot(p, p) > 0.25) discard;
  gl_FragColor = vec4(shade, 1.0);
}`;

const modes: Record<PointColor, number> = { image: 0, height: 1, age: 2, uncertainty: 3, run: 4 };

/** A step without a common divisor with `n`, near the golden section: k * step mod n visits all, evenly. */
export function evenStep(n: number): number {
  const divisor = (a: number, b: number): number => (b === 0 ? a : divisor(b, a % b));
  let step = Math.max(1, Math.round(n * 0.6180339887));
  while (n > 1 && divisor(n, step) !== 1) step++;
  return n > 1 ? step % n : 0;
}

export class PointsLayer implements LayerObject {
  readonly key: string;
  readonly label: string;
  readonly detail: string;
  readonly object: THREE.Points<THREE.BufferGeometry, THREE.ShaderMaterial>;
  readonly shownAtFirst = true;
  readonly modes: Set<PointColor>;
  maxSigma = Infinity;

  constructor(readonly data: PointsData, keyframes: Keyframes | null, runColor: string) {
    this.key = `points:${data.name}`;
    this.label = titled(data.name);
    this.detail = data.count === 0 ? 'empty' : count(data.count, 'point');
    this.modes = availableModes(data);
    this.object = new THREE.Points(geometryOf(data, keyframes), material(runColor));
    this.object.frustumCulled = false;
    this.object.layers.set(pointsMask);
  }

  applyStyle(style: Style): void {
    const mode = this.modes.has(style.pointColor) ? style.pointColor : fallback(this.modes);
    const uniforms = this.object.material.uniforms;
    this.maxSigma = this.data.sigmas ? style.maxSigma : Infinity;
    uniforms.mode.value = modes[mode];
    uniforms.size.value = style.pointSize * Math.min(2, devicePixelRatio);
    uniforms.maxSigma.value = Number.isFinite(this.maxSigma) ? this.maxSigma : 3e38;
    uniforms.range.value.set(...(style.ranges[mode as RangeName] ?? [0, 1]));
    uniforms.up.value.set(...style.up);
    uniforms.map.value = mapTexture(style.map);
  }

  /** The part of the points that is drawn next, as shares of the whole. */
  setSlice(from: number, to: number): void {
    const start = Math.round(from * this.data.count);
    this.object.geometry.setDrawRange(start, Math.round(to * this.data.count) - start);
  }
}

function fallback(modes: Set<PointColor>): PointColor {
  return modes.has('image') ? 'image' : 'height';
}

function availableModes(data: PointsData): Set<PointColor> {
  const modes = new Set<PointColor>(['height', 'run']);
  if (data.colors) modes.add('image');
  if (data.sigmas) modes.add('uncertainty');
  if (data.keyframes) modes.add('age');
  return modes;
}

function material(runColor: string): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    vertexShader,
    fragmentShader,
    uniforms: {
      mode: { value: 1 },
      size: { value: 2 },
      maxSigma: { value: 3e38 },
      range: { value: new THREE.Vector2(0, 1) },
      up: { value: new THREE.Vector3(0, 0, 1) },
      flatColor: { value: new THREE.Vector3(...hexToRgb(runColor)) },
      map: { value: mapTexture('viridis') },
    },
  });
}

function geometryOf(data: PointsData, keyframes: Keyframes | null): THREE.BufferGeometry {
  const n = data.count;
  const order = evenOrder(n);
  const geometry = new THREE.BufferGeometry();
  geometry.boundingSphere = new THREE.Sphere(); // never culled; computing it would pass over all points again
  geometry.setAttribute('position', attribute(reorder(data.positions, order, new Float32Array(3 * n), 3, 3), 3));
  if (data.colors) {
    const colors = reorder(data.colors, order, new Uint8Array(4 * n), 3, 4);
    geometry.setAttribute('color', attribute(colors, 4, true));
  }
  if (data.sigmas) geometry.setAttribute('sigma', attribute(reorder(data.sigmas, order, new Float32Array(n), 1, 1), 1));
  if (data.keyframes && keyframes) geometry.setAttribute('age', attribute(ages(data.keyframes, order, keyframes), 1));
  return geometry;
}

/** The copy in the graphics card is enough: the scene's own arrays serve for picking. */
function attribute(array: Float32Array | Uint8Array, size: number, normalized = false): THREE.BufferAttribute {
  const result = new THREE.BufferAttribute(array, size, normalized);
  result.onUpload(function (this: THREE.BufferAttribute) {
    this.array = this.array.subarray(0, 0) as typeof array;
  });
  return result;
}

function evenOrder(n: number): Uint32Array {
  const order = new Uint32Array(n);
  const step = evenStep(n);
  for (let k = 0, row = 0; k < n; k++) {
    order[k] = row;
    row += step;
    if (row >= n) row -= n;
  }
  return order;
}

function reorder<T extends Float32Array | Uint8Array>(
  from: T, order: Uint32Array, to: T, columnsFrom: number, columnsTo: number,
): T {
  for (let k = 0; k < order.length; k++) {
    const a = order[k] * columnsFrom;
    const b = k * columnsTo;
    for (let c = 0; c < columnsFrom; c++) to[b + c] = from[a + c];
  }
  return to;
}

/** Seconds since the keyframe of each point, counted from the last keyframe. */
export function ageOf(row: number, keyframes: Keyframes): number {
  return keyframes.stamps[keyframes.count - 1] - keyframes.stamps[row];
}

function ages(rows: Uint32Array, order: Uint32Array, keyframes: Keyframes): Float32Array {
  const result = new Float32Array(rows.length);
  for (let k = 0; k < rows.length; k++) result[k] = ageOf(rows[order[k]], keyframes);
  return result;
}
