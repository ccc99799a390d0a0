// SPDX-License-Identifier: Apache-2.0
// How many points are drawn in one picture: learned from the time between pictures.

const slowestMs = 50;
const fastestMs = 25;

export class Budget {
  points: number;

  constructor(gl: WebGLRenderingContext | WebGL2RenderingContext) {
    const info = gl.getExtension('WEBGL_debug_renderer_info');
    const name = info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : '';
    this.points = /swiftshader|llvmpipe|software/i.test(name) ? 4e5 : 3e6;
  }

  learn(intervalMs: number): void {
    if (intervalMs > 1000) return; // the page was hidden or waited
    if (intervalMs > slowestMs) this.points = Math.max(1e5, this.points * 0.8);
    if (intervalMs < fastestMs) this.points = Math.min(2e7, this.points * 1.25);
  }
}
