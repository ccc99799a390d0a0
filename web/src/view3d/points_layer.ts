// SPDX-License-Identifier: Apache-2.0
// Points of one layer as one buffer, drawn in classes that are each an even sample of the whole: some while the view
// moves, the others afterwards.
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
uniform bool colored;
uniform sampler2D map;
varying vec3 shade;
void main() {
  float value = mode == 1 ? dot(position, up) : mode == 2 ? age : sigma;
  float share = clamp((value - range.x) / max(range.y - range.x, 1e-12), 0.0, 1.0);
  // One color for all would hide every form: the image's brightness is kept.
  float light = colored ? 0.45 + 0.77 * dot(color.rgb, vec3(0.2126, 0.7152, 0.0722)) : 1.0;
  shade = mode == 0 ? color.rgb : mode == 4 ? flatColor * light : texture2D(map, vec2(share, 0.5)).rgb;
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

/** Large layers are drawn in this many classes; class j holds the points j, j + classes, j + 2 * classes, ... It is a
 * prime, so that the rows and columns of a depth image are sampled evenly, and the largest for which the distance of
 * two positions stays within the 255 bytes that WebGL allows. */
export const classes = 19;
const smallCount = 1e5;
const previewCount = 6e4;

export class PointsLayer implements LayerObject {
  readonly key: string;
  readonly label: string;
  readonly detail: string;
  readonly object = new THREE.Group();
  readonly shownAtFirst = true;
  readonly modes: Set<PointColor>;
  maxSigma = Infinity;
  protected readonly material: THREE.ShaderMaterial;
  private readonly parts: THREE.Points[];
  /** A small sample, for pictures while the view moves on a slow computer. */
  private readonly preview: THREE.Points | null;

  constructor(readonly data: PointsData, protected readonly keyframes: Keyframes | null, runColor: string) {
    const whole = data.tiles?.url ? data.tiles.count : data.count;
    this.key = `points:${data.name}`;
    this.label = titled(data.name);
    this.detail = whole === 0 ? 'empty' : count(whole, 'point');
    this.modes = availableModes(data);
    this.material = material(runColor, data.colors !== null);
    this.parts = geometriesOf(data, keyframes).map((geometry) => this.part(geometry));
    this.preview = data.count < smallCount ? null : this.part(geometriesOf(sampleOf(data), keyframes)[0]);
  }

  /** What a picture at this view shows of it, whole. */
  get shown(): PointsData[] {
    return [this.data];
  }

  get shownCount(): number {
    return this.shown.reduce((sum, data) => sum + data.count, 0);
  }

  protected part(geometry: THREE.BufferGeometry): THREE.Points {
    const points = new THREE.Points(geometry, this.material);
    points.frustumCulled = false;
    points.layers.set(pointsMask);
    this.object.add(points);
    return points;
  }

  applyStyle(style: Style): void {
    const mode = this.modes.has(style.pointColor) ? style.pointColor : fallback(this.modes);
    const uniforms = this.material.uniforms;
    this.maxSigma = this.data.sigmas ? style.maxSigma : Infinity;
    uniforms.mode.value = modes[mode];
    uniforms.size.value = style.pointSize * Math.min(2, devicePixelRatio);
    uniforms.maxSigma.value = Number.isFinite(this.maxSigma) ? this.maxSigma : 3e38;
    uniforms.range.value.set(...(style.ranges[mode as RangeName] ?? [0, 1]));
    uniforms.up.value.set(...style.up);
    uniforms.map.value = mapTexture(style.map);
  }

  /** Which classes are drawn next, none for the preview. A small layer is drawn whole in the picture's first slice. */
  setSlice(from: number, to: number, first: boolean): void {
    if (this.preview) this.preview.visible = to === 0;
    this.parts.forEach((points, j) => {
      points.visible = this.preview ? j >= from && j < to : first;
    });
  }

  get previewCount(): number {
    return this.preview ? sampleRows(this.data.count).length : this.data.count;
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

function material(runColor: string, colored: boolean): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    vertexShader,
    fragmentShader,
    uniforms: {
      mode: { value: 1 },
      size: { value: 2 },
      colored: { value: colored },
      maxSigma: { value: 3e38 },
      range: { value: new THREE.Vector2(0, 1) },
      up: { value: new THREE.Vector3(0, 0, 1) },
      flatColor: { value: new THREE.Vector3(...hexToRgb(runColor)) },
      map: { value: mapTexture('viridis') },
    },
  });
}

function sampleRows(count: number): Uint32Array {
  const step = Math.ceil(count / previewCount);
  return Uint32Array.from({ length: Math.floor(count / step) }, (_, i) => i * step);
}

function sampleOf(data: PointsData): PointsData {
  const rows = sampleRows(data.count);
  const take = <T extends Float32Array | Uint8Array | Uint32Array>(from: T, columns: number): T => {
    const to = from.slice(0, rows.length * columns) as T;
    rows.forEach((row, i) => to.set(from.subarray(row * columns, (row + 1) * columns), i * columns));
    return to;
  };
  return {
    ...data,
    count: rows.length,
    positions: take(data.positions, 3),
    colors: data.colors && take(data.colors, 3),
    sigmas: data.sigmas && take(data.sigmas, 1),
    keyframes: data.keyframes && take(data.keyframes, 1),
    tiles: null,
  };
}

/** One geometry a class. They share the buffers, which are the scene's own arrays: nothing is copied or sorted. */
export function geometriesOf(data: PointsData, keyframes: Keyframes | null): THREE.BufferGeometry[] {
  const n = data.count < smallCount ? 1 : classes;
  const shared: [string, THREE.InterleavedBuffer, number][] = [];
  const share = (name: string, array: Float32Array | Uint8Array, columns: number) =>
    shared.push([name, new THREE.InterleavedBuffer(array, columns * n), columns]);
  share('position', data.positions, 3);
  if (data.colors) share('color', padded(data.colors), 4);
  if (data.sigmas) share('sigma', data.sigmas, 1);
  if (data.keyframes && keyframes) share('age', ages(data.keyframes, keyframes), 1);
  // Neighboring classes lie in neighboring points: a step of 7 spreads the first ones over the whole.
  return Array.from({ length: n }, (_, j) => classGeometry(shared, n === 1 ? 0 : (7 * j) % n, n, data.count));
}

function classGeometry(
  shared: [string, THREE.InterleavedBuffer, number][], first: number, n: number, count: number,
): THREE.BufferGeometry {
  const geometry = new THREE.BufferGeometry();
  geometry.boundingSphere = new THREE.Sphere(); // never culled; computing it would pass over all points
  for (const [name, buffer, columns] of shared) {
    const bytes = buffer.array instanceof Uint8Array;
    geometry.setAttribute(name, new THREE.InterleavedBufferAttribute(buffer, columns, first * columns, bytes));
  }
  geometry.setDrawRange(0, Math.ceil((count - first) / n));
  return geometry;
}

/** Graphics cards want attributes at multiples of four bytes. */
export function padded(colors: Uint8Array): Uint8Array {
  const result = new Uint8Array((colors.length / 3) * 4);
  for (let i = 0, k = 0; i < colors.length; i += 3, k += 4) {
    result[k] = colors[i];
    result[k + 1] = colors[i + 1];
    result[k + 2] = colors[i + 2];
  }
  return result;
}

/** Seconds since the keyframe of each point, counted from the last keyframe. */
export function ageOf(row: number, keyframes: Keyframes): number {
  return keyframes.stamps[keyframes.count - 1] - keyframes.stamps[row];
}

function ages(rows: Uint32Array, keyframes: Keyframes): Float32Array {
  return Float32Array.from(rows, (row) => ageOf(row, keyframes));
}
