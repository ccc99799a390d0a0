// SPDX-License-Identifier: Apache-2.0
// Surfaces: a mesh, and the cubes of an octree. Both are colored from the images or by height.
import * as THREE from 'three';
import type { CubesLayer as CubesData, MeshLayer as MeshData } from '../scene/scene';
import { hexToRgb } from './colors';
import { mapTexture } from './materials';
import { padded } from './points_layer';
import { count, titled, type LayerObject, type Style } from './style';

// The light stands at the eye: every side that is seen is lit, and edges show by the angle.
const shading = `
uniform int mode;
uniform vec2 range;
uniform vec3 up;
uniform vec3 flatColor;
uniform sampler2D map;
varying vec3 tint;
varying vec3 inView;
vec3 colorAt(vec3 p, vec3 own) {
  float share = clamp((dot(p, up) - range.x) / max(range.y - range.x, 1e-12), 0.0, 1.0);
  return mode == 0 ? own : mode == 4 ? flatColor : texture2D(map, vec2(share, 0.5)).rgb;
}`;

const meshVertex = `
attribute vec4 color;
${shading}
void main() {
  tint = colorAt(position, color.rgb);
  vec4 p = modelViewMatrix * vec4(position, 1.0);
  inView = p.xyz;
  gl_Position = projectionMatrix * p;
}`;

const cubesVertex = `
attribute vec3 center;
attribute float edge;
attribute vec4 color;
${shading}
void main() {
  tint = colorAt(center, color.rgb);
  vec4 p = modelViewMatrix * vec4(center + edge * position, 1.0);
  inView = p.xyz;
  gl_Position = projectionMatrix * p;
}`;

const fragment = `
varying vec3 tint;
varying vec3 inView;
void main() {
  vec3 normal = normalize(cross(dFdx(inView), dFdy(inView)));
  float facing = abs(dot(normal, normalize(inView)));
  gl_FragColor = vec4(tint * (0.45 + 0.55 * facing), 1.0);
}`;

class SurfaceLayer implements LayerObject {
  readonly object: THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial>;
  readonly shownAtFirst = true;

  constructor(
    readonly key: string,
    readonly label: string,
    readonly detail: string,
    geometry: THREE.BufferGeometry,
    vertexShader: string,
    private readonly hasColors: boolean,
    runColor: string,
  ) {
    geometry.boundingSphere = new THREE.Sphere(); // never culled
    this.object = new THREE.Mesh(geometry, surfaceMaterial(vertexShader, runColor));
    this.object.frustumCulled = false;
  }

  applyStyle(style: Style): void {
    const uniforms = this.object.material.uniforms;
    const image = this.hasColors && style.pointColor !== 'height';
    uniforms.mode.value = style.pointColor === 'run' ? 4 : image ? 0 : 1;
    uniforms.range.value.set(...(style.ranges.height ?? [0, 1]));
    uniforms.up.value.set(...style.up);
    uniforms.map.value = mapTexture(style.map);
  }
}

function surfaceMaterial(vertexShader: string, runColor: string): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    vertexShader,
    fragmentShader: fragment,
    side: THREE.DoubleSide,
    uniforms: {
      mode: { value: 1 },
      range: { value: new THREE.Vector2(0, 1) },
      up: { value: new THREE.Vector3(0, 0, 1) },
      flatColor: { value: new THREE.Vector3(...hexToRgb(runColor)) },
      map: { value: mapTexture('viridis') },
    },
  });
}

export function meshLayer(data: MeshData, runColor: string): LayerObject {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(data.positions, 3));
  geometry.setIndex(new THREE.BufferAttribute(data.triangles, 1));
  if (data.colors) geometry.setAttribute('color', new THREE.BufferAttribute(padded(data.colors), 4, true));
  const detail = data.count === 0 ? 'empty' : count(data.count, 'triangle');
  return new SurfaceLayer(`mesh:${data.name}`, titled(data.name), detail, geometry, meshVertex, data.colors !== null, runColor);
}

export function cubesLayer(data: CubesData, runColor: string): LayerObject {
  const box = new THREE.BoxGeometry(1, 1, 1);
  const geometry = new THREE.InstancedBufferGeometry();
  geometry.setIndex(box.index);
  geometry.setAttribute('position', box.getAttribute('position'));
  geometry.setAttribute('center', new THREE.InstancedBufferAttribute(data.centers, 3));
  geometry.setAttribute('edge', new THREE.InstancedBufferAttribute(data.sizes, 1));
  if (data.colors) geometry.setAttribute('color', new THREE.InstancedBufferAttribute(padded(data.colors), 4, true));
  geometry.instanceCount = data.count;
  const detail = data.count === 0 ? 'empty' : count(data.count, 'cube');
  return new SurfaceLayer(`cubes:${data.name}`, titled(data.name), detail, geometry, cubesVertex, data.colors !== null, runColor);
}
