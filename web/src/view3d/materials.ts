// SPDX-License-Identifier: Apache-2.0
// Textures and small materials that several layers share.
import * as THREE from 'three';
import type { Vec3 } from '../scene/scene';
import { hexToRgb, mapBytes, type MapName } from './colors';

// Colors are meant as they are written: three.js must not convert them between color spaces.
THREE.ColorManagement.enabled = false;

const textures = new Map<MapName, THREE.DataTexture>();

export function mapTexture(map: MapName): THREE.DataTexture {
  let texture = textures.get(map);
  if (!texture) {
    texture = new THREE.DataTexture(mapBytes(map), 256, 1);
    texture.magFilter = THREE.LinearFilter;
    texture.minFilter = THREE.LinearFilter;
    texture.needsUpdate = true;
    textures.set(map, texture);
  }
  return texture;
}

/** Whether the point that begins at `i` can be drawn; beyond, the arithmetic of graphics cards overflows. */
export function drawable(positions: ArrayLike<number>, i: number): boolean {
  return Math.abs(positions[i]) < 1e12 && Math.abs(positions[i + 1]) < 1e12 && Math.abs(positions[i + 2]) < 1e12;
}

/** Thin lines, one pixel wide. */
export function thinLines(positions: Float32Array, color: string, opacity = 1): THREE.LineSegments<THREE.BufferGeometry, THREE.LineBasicMaterial> {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  const material = new THREE.LineBasicMaterial({ color, transparent: opacity < 1, opacity });
  geometry.boundingSphere = new THREE.Sphere(); // never culled, see below
  const lines = new THREE.LineSegments(geometry, material);
  lines.frustumCulled = false;
  return lines;
}

const dotVertex = `
uniform float size;
void main() {
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_PointSize = size;
}`;

// The dark rim keeps a dot visible on any ground.
const dotFragment = `
uniform vec3 tint;
void main() {
  float r = 2.0 * length(gl_PointCoord - 0.5);
  if (r > 1.0) discard;
  gl_FragColor = vec4(r > 0.75 ? vec3(0.0) : tint, 1.0);
}`;

/** Round marks of a fixed size in pixels, never hidden by anything else. */
export function dots(points: Vec3[], color: string, size: number): THREE.Points {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(Float32Array.from(points.flat()), 3));
  const material = new THREE.ShaderMaterial({
    vertexShader: dotVertex,
    fragmentShader: dotFragment,
    depthTest: false,
    transparent: true, // drawn after all that is opaque
    uniforms: { tint: { value: new THREE.Vector3(...hexToRgb(color)) }, size: { value: size * Math.min(2, devicePixelRatio) } },
  });
  const object = new THREE.Points(geometry, material);
  object.frustumCulled = false;
  object.renderOrder = 11;
  return object;
}
