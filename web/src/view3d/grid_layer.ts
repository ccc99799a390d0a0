// SPDX-License-Identifier: Apache-2.0
// An occupancy grid as a picture on the plane z = 0 of the world.
import * as THREE from 'three';
import type { GridLayer as GridData } from '../scene/scene';
import { titled, type LayerObject, type Style } from './style';

export class GridLayer implements LayerObject {
  readonly key: string;
  readonly label: string;
  readonly detail: string;
  readonly object: THREE.Mesh<THREE.PlaneGeometry, THREE.MeshBasicMaterial>;
  readonly shownAtFirst = true;
  private readonly pixels: Uint8Array<ArrayBuffer>;
  private dark: boolean | null = null;
  private readonly texture: THREE.DataTexture;

  constructor(private readonly data: GridData) {
    this.key = `grid:${data.name}`;
    this.label = data.name === 'grid' ? 'Occupancy grid' : titled(data.name);
    this.detail = data.count === 0 ? 'empty' : `${data.width} x ${data.height} cells`;
    this.pixels = new Uint8Array(4 * Math.max(1, data.count));
    this.texture = new THREE.DataTexture(this.pixels, Math.max(1, data.width), Math.max(1, data.height));
    this.texture.magFilter = THREE.NearestFilter;
    this.texture.minFilter = THREE.LinearFilter;
    const [w, h] = [data.width * data.cell, data.height * data.cell];
    const material = new THREE.MeshBasicMaterial({
      // Drawn first and without depth: lines and points in the same plane stay visible.
      map: this.texture, alphaTest: 0.5, depthWrite: false, side: THREE.DoubleSide,
    });
    this.object = new THREE.Mesh(new THREE.PlaneGeometry(w, h), material);
    this.object.position.set(data.origin[0] + w / 2, data.origin[1] + h / 2, 0);
    this.object.frustumCulled = false;
    this.object.visible = data.count > 0;
    this.object.renderOrder = -1;
  }

  applyStyle(style: Style): void {
    if (style.dark === this.dark) return;
    this.dark = style.dark;
    const free = style.dark ? 56 : 250;
    const occupied = style.dark ? 235 : 20;
    this.data.cells.forEach((cell, i) => {
      const gray = cell === 255 ? 128 : free + ((occupied - free) * cell) / 254;
      this.pixels.fill(gray, 4 * i, 4 * i + 3);
      this.pixels[4 * i + 3] = cell === 255 ? 0 : 255;
    });
    this.texture.needsUpdate = true;
  }
}
