// SPDX-License-Identifier: Apache-2.0
// Saves what is seen as a video: one turn around the map, or the timeline as it is played. Recorded in real time by the
// browser's own encoder; a slow computer gives fewer pictures a second, never a slower video.
import * as THREE from 'three';
import type { App } from '../app';
import type { Player } from '../timeline/player';
import { button, el } from './dom';
import { icon } from './icons';
import { saveAs } from './picture';

const rate = 30;
const turnSeconds = 12;
const endSeconds = 0.4;
const types = ['video/mp4;codecs=avc1.640028', 'video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm'];

export type VideoKind = 'turn' | 'timeline';

export class Video {
  readonly dialog = el('dialog', { className: 'ask', aria: { label: 'Save a video' } });
  private recorder: MediaRecorder | null = null;
  private readonly listeners: (() => void)[] = [];

  constructor(private readonly app: App, private readonly player: Player) {}

  get isOn(): boolean {
    return this.recorder !== null;
  }

  /** Called where a video begins or ends. */
  onSwitch(listener: () => void): void {
    this.listeners.push(listener);
  }

  /** Asks what to record; ends a video that is being recorded. */
  ask(): void {
    if (this.recorder) return this.recorder.stop();
    if (this.dialog.open) return this.dialog.close();
    const type = typeof MediaRecorder === 'undefined' ? undefined : types.find((t) => MediaRecorder.isTypeSupported(t));
    this.dialog.replaceChildren(
      el('div', { className: 'row' }, el('h2', {}, 'Save a video'), button('Close', 'Close (Esc)', () => this.dialog.close(), icon('close'))),
      ...(type ? this.choices(type) : [el('p', {}, 'This browser cannot record videos. Firefox, Chrome and Safari of the last years can.')]));
    this.dialog.showModal();
  }

  private choices(type: string): HTMLElement[] {
    const { frames } = this.app;
    const choice = (kind: VideoKind, label: string) => button(label, label, () => {
      this.dialog.close();
      this.start(kind, type);
    });
    const seconds = frames ? (frames.stamps[frames.count - 1] - frames.stamps[0]) / this.player.speed : 0;
    const played = choice('timeline', frames ? `Timeline from its begin, speed ${this.player.speed} (about ${Math.ceil(seconds)} s)` : 'Timeline');
    played.disabled = !frames || frames.count < 2;
    return [
      el('div', { className: 'choices' }, choice('turn', `One turn around the map (${turnSeconds} s)`), played),
      el('p', {}, `The view is recorded as it is drawn, without labels and legend, as ${type.includes('mp4') ? 'MP4' : 'WebM'}. B ends it early.`),
    ];
  }

  private start(kind: VideoKind, type: string): void {
    const stream = this.app.view.canvas.captureStream(rate);
    const parts: Blob[] = [];
    const recorder = new MediaRecorder(stream, { mimeType: type, videoBitsPerSecond: 8e6 });
    recorder.ondataavailable = (event) => parts.push(event.data);
    recorder.onstop = () => {
      for (const track of stream.getTracks()) track.stop();
      this.recorder = null;
      this.switched();
      const blob = new Blob(parts, { type: type.split(';')[0] });
      if (blob.size > 0) saveAs(this.app, blob, type.includes('mp4') ? 'mp4' : 'webm');
    };
    this.recorder = recorder;
    recorder.start(1000);
    this.switched();
    if (kind === 'turn') this.turn(recorder);
    else this.play(recorder);
  }

  private turn(recorder: MediaRecorder): void {
    const { camera, controls } = this.app.view;
    const from = camera.position.clone();
    const axis = new THREE.Vector3(...this.app.up);
    const begin = performance.now();
    const step = () => {
      const share = this.recorder === recorder ? Math.min(1, (performance.now() - begin) / (1000 * turnSeconds)) : 1;
      const arm = from.clone().sub(controls.target).applyAxisAngle(axis, share < 1 ? 2 * Math.PI * share : 0);
      camera.position.copy(controls.target).add(arm);
      controls.update();
      this.app.view.requestDraw();
      if (share < 1) requestAnimationFrame(step);
      else this.end(recorder);
    };
    step();
  }

  private play(recorder: MediaRecorder): void {
    this.player.go(0);
    this.player.toggle();
    const wait = () => {
      if (this.recorder !== recorder) return this.player.stop();
      if (this.player.isPlaying) requestAnimationFrame(wait);
      else this.end(recorder);
    };
    requestAnimationFrame(wait);
  }

  /** The last picture stays a moment, and the encoder gets it. */
  private end(recorder: MediaRecorder): void {
    const begin = performance.now();
    const wait = () => {
      if (this.recorder !== recorder) return;
      this.app.view.requestDraw();
      if (performance.now() - begin < 1000 * endSeconds) requestAnimationFrame(wait);
      else recorder.stop();
    };
    wait();
  }

  private switched(): void {
    for (const listener of this.listeners) listener();
  }
}
