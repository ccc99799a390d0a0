// SPDX-License-Identifier: Apache-2.0
// Textures and small materials that several layers share.
import * as THREE from 'three';
import { mapBytes, type MapName } from './colors';

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

/** Thin lines, one pixel wide. */
export function thinLines(positions: Float32Array, color: string, opacity = 1): THREE.LineSegments<THREE.BufferGeometry, THREE.LineBasicMaterial> {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  const material = new THREE.LineBasicMaterial({ color, transparent: opacity < 1, opacity });
  const lines = new THREE.LineSegments(geometry, material);
  lines.frustumCulled = false;
  return lines;
}
