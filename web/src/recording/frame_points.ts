// SPDX-License-Identifier: Apache-2.0
// What the current frame of a recording measured, in the 3D view: depth as a cloud, or a scan.
import * as THREE from 'three';
import type { App } from '../app';
import { robustBox } from '../view3d/bounds';
import { corners } from '../view3d/viewpoint';
import { okabeIto } from '../view3d/colors';
import type { RecordedFrame } from './frame_block';

export class FramePoints {
  private readonly cloud = new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({ size: 2, sizeAttenuation: false }));
  private seen = false;
  private shown = false;

  constructor(private readonly app: App) {
    this.cloud.frustumCulled = false;
    this.cloud.visible = false;
    app.view.marks.add(this.cloud);
  }

  /** There is no frame whose points are known. */
  hide(): void {
    this.shown = false;
    this.update();
  }

  /** After the run was switched on or off. */
  update(): void {
    this.cloud.visible = this.shown && (this.app.active?.group.visible ?? false);
    this.app.view.requestDraw();
  }

  /** `row`: of the frames, whose pose the points are placed at; without one they are where the camera began. */
  show(frame: RecordedFrame, row: number): void {
    const { cloud } = this;
    this.shown = frame.points.length > 0;
    this.update();
    if (!this.shown) return;
    cloud.geometry.dispose();
    cloud.geometry = new THREE.BufferGeometry();
    cloud.geometry.setAttribute('position', new THREE.BufferAttribute(frame.points, 3));
    if (frame.colors) cloud.geometry.setAttribute('color', new THREE.BufferAttribute(frame.colors, 3, true));
    Object.assign(cloud.material, { vertexColors: frame.colors !== null, size: 2 * Math.min(2, devicePixelRatio) });
    cloud.material.color.set(frame.colors ? '#ffffff' : okabeIto.skyBlue);
    cloud.material.needsUpdate = true;
    this.place(row);
    this.lookAt(frame);
  }

  /** Where the camera of the frame was; without a pose where it would have begun. */
  private place(row: number): void {
    const { frames } = this.app;
    const p = [...(frames?.positions.subarray(3 * row, 3 * row + 3) ?? [])];
    const q = [...(frames?.orientations.subarray(4 * row, 4 * row + 4) ?? [])];
    const known = p.length === 3 && q.length === 4 && [...p, ...q].every(Number.isFinite);
    this.cloud.position.fromArray(known ? p : [0, 0, 0]);
    this.cloud.quaternion.fromArray(known ? q : [0, 0, 0, 1]).normalize();
    this.cloud.updateMatrixWorld();
  }

  /** The first points belong to what the view is fitted to: a camera that only turns has hardly any trajectory. */
  private lookAt(frame: RecordedFrame): void {
    const { app } = this;
    const box = robustBox(frame.points, 3, 0.02);
    if (this.seen || box.isEmpty()) return;
    this.seen = true;
    box.applyMatrix4(this.cloud.matrixWorld).expandByPoint(this.cloud.position);
    const posed = app.frames !== null && app.frames.positions.some(Number.isFinite);
    const whole = posed ? box.union(app.view.bounds) : box;
    app.view.setContent(whole, corners(whole), app.up);
    app.contentGrew();
    if (app.state.camera === null) app.fit();
  }
}
