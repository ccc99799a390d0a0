// SPDX-License-Identifier: Apache-2.0
// Keeps the mark of the current frame in the view where the timeline is, and looks from its camera.
import * as THREE from 'three';
import type { App } from '../app';
import { FrameMarker } from '../view3d/frame_marker';

export class CurrentFrame {
  private marker: FrameMarker | null = null;
  private run = -1;
  private camera = '';
  follow = false;
  private readonly last = new THREE.Vector3();
  private readonly listeners: (() => void)[] = [];

  constructor(private readonly app: App) {
    app.onChange(() => this.update());
    this.update();
  }

  /** The eye goes where the camera (or laser) of the current frame was. */
  look(): void {
    const { frames, active } = this.app;
    if (!frames || !this.marker?.object.visible) return;
    const { position, quaternion } = this.marker.object;
    const axis = active!.scene.camera ? new THREE.Vector3(0, 0, 1) : new THREE.Vector3(1, 0, 0);
    const distance = this.app.view.bounds.getSize(new THREE.Vector3()).length() / 6;
    this.app.view.lookFrom(position, axis.applyQuaternion(quaternion).multiplyScalar(distance));
    this.app.rememberCamera();
  }

  onFollow(listener: () => void): void {
    this.listeners.push(listener);
  }

  setFollow(on: boolean): void {
    this.follow = on;
    if (on && this.marker?.object.visible) this.moveAlong(this.app.view.controls.target.clone());
    for (const listener of this.listeners) listener();
  }

  /** Eye and target go the same way as the current frame went from `from`. */
  private moveAlong(from: THREE.Vector3): void {
    const { camera, controls } = this.app.view;
    const move = this.marker!.object.position.clone().sub(from);
    camera.position.add(move);
    controls.target.add(move);
    controls.update();
  }

  private update(): void {
    const { frames, active, state, view } = this.app;
    const camera = JSON.stringify(active?.scene.camera ?? null);
    if (this.run !== state.active || this.camera !== camera || !this.marker) {
      if (this.marker) {
        view.marks.remove(this.marker.object);
        this.marker.dispose();
      }
      [this.run, this.camera] = [state.active, camera];
      this.marker = new FrameMarker(active?.scene.camera ?? null);
      view.marks.add(this.marker.object);
    }
    this.marker.object.visible = false;
    if (frames && active!.group.visible) this.marker.place(frames, state.frame, state.cameraSize, this.app.dark);
    if (this.follow && this.marker.object.visible && !this.last.equals(this.marker.object.position)) this.moveAlong(this.last);
    this.last.copy(this.marker.object.position);
    view.requestDraw();
  }
}
