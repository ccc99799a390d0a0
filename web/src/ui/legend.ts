// SPDX-License-Identifier: Apache-2.0
// The legend in the corner of the view: what the colors mean, and a scale bar.
import * as THREE from 'three';
import type { App } from '../app';
import type { Frames } from '../scene/scene';
import { mapGradient, stateColor } from '../view3d/colors';
import { PointsLayer } from '../view3d/points_layer';
import { niceStep } from '../view3d/reference';
import type { RangeName } from '../view3d/style';
import { el } from './dom';
import { digits, lengthText, unitOf } from './units';

const titles: Record<RangeName, string> = {
  height: 'Height', age: 'Age of points', uncertainty: 'Sigma of points', error: 'Error', sigma: 'Position sigma', time: 'Time',
};

export class Legend {
  readonly element = el('div', { className: 'legend', aria: { label: 'Legend' } });
  private readonly colors = el('div');
  private readonly bar = el('div', { className: 'scale-bar', title: 'Length at the center of the view' });

  constructor(private readonly app: App) {
    this.element.append(this.colors, this.bar);
    app.onChange(() => this.fill());
    this.fill();
  }

  /** After each picture: the bar's length depends on the distance of the eye. */
  update(): void {
    const { camera, controls, canvas } = this.app.view;
    const height = 2 * camera.position.distanceTo(controls.target) * Math.tan(THREE.MathUtils.degToRad(camera.fov / 2));
    const perPixel = height / Math.max(1, canvas.clientHeight);
    const factor = this.app.scaleFactors.get(this.app.state.active)?.factor ?? 1;
    const length = niceStep(64 * perPixel * factor) / factor;
    this.bar.style.width = `${length / perPixel}px`;
    this.bar.textContent = lengthText(this.app, length, null);
  }

  private fill(): void {
    const { app } = this;
    const shown = app.runs.filter((r) => r.group.visible).flatMap((r) => r.layers).filter((l) => l.object.visible);
    const parts: HTMLElement[] = [];
    if (shown.some((l) => l.key === 'trajectory:final')) parts.push(...this.trajectory());
    const colored = shown.some((l) => l instanceof PointsLayer || /^(mesh|cubes)/.test(l.key));
    if (colored && app.state.pointColor !== 'image' && app.state.pointColor !== 'run') parts.push(...this.gradient(app.state.pointColor));
    if (app.runs.length > 1) parts.push(this.runs());
    this.colors.replaceChildren(...parts);
  }

  private trajectory(): HTMLElement[] {
    const mode = this.app.state.trajectoryColor;
    if (mode === 'run') return [];
    if (mode !== 'state') return this.gradient(mode);
    const frames = this.app.frames;
    return frames?.states ? [el('div', { className: 'keys' }, ...states(frames, this.app.active!.scene.stateNames))] : [];
  }

  private gradient(name: RangeName): HTMLElement[] {
    const range = this.app.style.ranges[name];
    if (!range) return [];
    const unit = name === 'age' || name === 'time' ? 's' : unitOf(this.app);
    const factor = unit === 's' ? 1 : this.app.scaleFactors.get(this.app.state.active)?.factor ?? 1;
    return [el('div', { className: 'ramp' },
      el('span', { className: 'title' }, `${titles[name]} [${unit}]`),
      el('span', { className: 'colors', style: `background:${mapGradient(this.app.state.map)}` }),
      el('span', { className: 'ends' }, el('span', {}, digits(range[0] * factor)), el('span', {}, digits(range[1] * factor))))];
  }

  private runs(): HTMLElement {
    return el('div', { className: 'keys' }, ...this.app.runs.filter((r) => r.group.visible).map((r) => key(r.color, r.name)));
  }
}

function key(color: string, text: string): HTMLElement {
  return el('span', { className: 'key' }, el('span', { className: 'swatch', style: `background:${color}` }), text);
}

/** Only states that occur, with their share of the frames. */
function states(frames: Frames, names: string[]): HTMLElement[] {
  const counts = new Array<number>(names.length).fill(0);
  for (const state of frames.states!) counts[state]++;
  return names.flatMap((name, i) => {
    if (counts[i] === 0) return [];
    const share = (100 * counts[i]) / frames.count;
    return [key(stateColor(name), `${name} ${share < 1 ? '< 1' : Math.round(share)} %`)];
  });
}
