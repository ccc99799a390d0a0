// SPDX-License-Identifier: Apache-2.0
// Plays the frames in the time of their stamps, faster or slower.
import type { App } from '../app';
import { frameAt } from './track';

/** A pause in the recording is shortened to this. */
const longestWaitSeconds = 1;

export class Player {
  speed = 1;
  private playing = false;
  private stamp = 0;
  private last = 0;

  constructor(private readonly app: App, private readonly onSwitch: () => void) {}

  get isPlaying(): boolean {
    return this.playing;
  }

  toggle(): void {
    const { frames } = this.app;
    if (!frames) return;
    this.playing = !this.playing;
    if (this.playing) {
      if (this.app.state.frame >= frames.count - 1) this.app.set({ frame: 0 });
      this.stamp = frames.stamps[this.app.state.frame];
      this.last = performance.now();
      requestAnimationFrame(() => this.tick());
    }
    this.onSwitch();
  }

  stop(): void {
    if (!this.playing) return;
    this.playing = false;
    this.onSwitch();
  }

  /** Goes to a frame by hand, which ends playing. */
  go(frame: number): void {
    const { frames } = this.app;
    if (!frames) return;
    this.stop();
    this.app.set({ frame: Math.min(frames.count - 1, Math.max(0, frame)) });
  }

  private tick(): void {
    const { frames } = this.app;
    if (!this.playing || !frames) return;
    const now = performance.now();
    this.stamp += ((now - this.last) / 1000) * this.speed;
    this.last = now;
    const current = Math.min(this.app.state.frame, frames.count - 1);
    const next = frames.stamps[Math.min(frames.count - 1, current + 1)];
    if (next - this.stamp > longestWaitSeconds * this.speed) this.stamp = next;
    const frame = Math.max(current, frameAt(frames.stamps, this.stamp));
    if (frame !== current) this.app.set({ frame });
    if (frame >= frames.count - 1) return this.stop();
    requestAnimationFrame(() => this.tick());
  }
}
