// SPDX-License-Identifier: Apache-2.0
// Keeps the mark of the current frame in the view where the timeline is, and looks from its camera.
import * as THREE from 'three';
import type { App } from '../app';
import { FrameMarker } from '../view3d/frame_marker';

export class CurrentFrame {
  private marker: FrameMarker | null = null;
  private run = -1;

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

  private update(): void {
    const { frames, active, state, view } = this.app;
    if (this.run !== state.active || !this.marker) {
      if (this.marker) view.marks.remove(this.marker.object);
      this.run = state.active;
      this.marker = new FrameMarker(active?.scene.camera ?? null);
      view.marks.add(this.marker.object);
    }
    this.marker.object.visible = false;
    if (frames && active!.group.visible) this.marker.place(frames, state.frame, state.cameraSize, this.app.dark);
    view.requestDraw();
  }
}
