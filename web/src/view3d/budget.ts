// SPDX-License-Identifier: Apache-2.0
// How many points are drawn in one picture: learned from the time between pictures.

const slowestMs = 50;
const fastestMs = 25;

/** Without a graphics card each point costs about a microsecond, and smooth edges four times as much. */
export function isSoftware(): boolean {
  const gl = document.createElement('canvas').getContext('webgl2');
  const info = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = gl && info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

export class Budget {
  points: number;
  /** Of tiles in a whole picture, which comes when the view rests. */
  readonly whole: number;

  constructor(software: boolean) {
    this.points = software ? 3e5 : 3e6;
    this.whole = software ? 2e6 : 5e6;
  }

  learn(intervalMs: number): void {
    if (intervalMs > 5000) return; // the page was hidden or waited
    if (intervalMs > slowestMs) this.points = Math.max(1e5, this.points * 0.7);
    if (intervalMs < fastestMs) this.points = Math.min(2e7, this.points * 1.25);
  }
}
