// SPDX-License-Identifier: Apache-2.0
// Covariances as ellipsoids: a sphere that the three semi-axes of each covariance stretch, all in one draw call.
import * as THREE from 'three';
import type { EllipsoidsLayer as EllipsoidsData } from '../scene/scene';
import { hexToRgb, okabeIto } from './colors';
import { count, titled, type LayerObject, type Style } from './style';

const vertexShader = `
attribute vec3 center;
attribute vec3 axisA;
attribute vec3 axisB;
attribute vec3 axisC;
uniform float scale;
varying vec3 inView;
void main() {
  vec3 onSphere = scale * (axisA * position.x + axisB * position.y + axisC * position.z);
  vec4 p = modelViewMatrix * vec4(center + onSphere, 1.0);
  inView = p.xyz;
  gl_Position = projectionMatrix * p;
}`;

const fragmentShader = `
uniform vec3 tint;
varying vec3 inView;
void main() {
  vec3 normal = normalize(cross(dFdx(inView), dFdy(inView)));
  float facing = abs(dot(normal, normalize(inView)));
  gl_FragColor = vec4(tint * (0.6 + 0.4 * facing), 0.55);
}`;

export class EllipsoidsLayer implements LayerObject {
  readonly key: string;
  readonly label: string;
  readonly detail: string;
  readonly object: THREE.Mesh<THREE.InstancedBufferGeometry, THREE.ShaderMaterial>;
  /** They hide what lies behind them; people who want them find the switch. */
  readonly shownAtFirst = false;

  constructor(data: EllipsoidsData) {
    this.key = `ellipsoids:${data.name}`;
    this.label = titled(data.name);
    this.detail = data.count === 0 ? 'none' : count(data.count, 'ellipsoid');
    const material = new THREE.ShaderMaterial({
      vertexShader,
      fragmentShader,
      transparent: true,
      uniforms: { scale: { value: 3 }, tint: { value: new THREE.Vector3(...hexToRgb(okabeIto.purple)) } },
    });
    this.object = new THREE.Mesh(geometryOf(data), material);
    this.object.frustumCulled = false;
  }

  applyStyle(style: Style): void {
    this.object.material.uniforms.scale.value = style.ellipsoidScale;
  }
}

function geometryOf(data: EllipsoidsData): THREE.InstancedBufferGeometry {
  const sphere = new THREE.IcosahedronGeometry(1, 2);
  const geometry = new THREE.InstancedBufferGeometry();
  geometry.boundingSphere = new THREE.Sphere(); // never culled
  geometry.setAttribute('position', sphere.getAttribute('position'));
  geometry.setAttribute('center', new THREE.InstancedBufferAttribute(data.centers, 3));
  const axes = new THREE.InstancedInterleavedBuffer(data.axes, 9);
  ['axisA', 'axisB', 'axisC'].forEach((name, i) => {
    geometry.setAttribute(name, new THREE.InterleavedBufferAttribute(axes, 3, 3 * i));
  });
  geometry.instanceCount = data.count;
  return geometry;
}
