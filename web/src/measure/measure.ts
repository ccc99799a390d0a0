// SPDX-License-Identifier: Apache-2.0
// Measuring by two clicks: the mode, the measured lengths, and the hint what to do next.
import type { App } from '../app';
import { el } from '../ui/dom';
import { shownCandidates } from './candidates';
import { lengthBetween, scaleFrom, type Length } from './length';
import { pick, type Picked } from './pick';

export interface Measured {
  name: string;
  a: Picked;
  b: Picked;
  run: number;
  /** In the unit of the run's map. */
  measured: Length;
  /** Entered by the person, in meters; the run's scale comes from it. */
  known: number | null;
}

const clickRadius = 14;
const touchRadius = 26;

export class Measure {
  readonly list: Measured[] = [];
  readonly hint = el('p', { className: 'hint', role: 'status', hidden: true });
  pending: Picked | null = null;
  active = false;
  private readonly listeners: (() => void)[] = [];
  private down: [number, number] | null = null;

  constructor(private readonly app: App) {
    const { canvas } = app.view;
    canvas.addEventListener('pointerdown', (e) => {
      this.down = e.button === 0 ? [e.clientX, e.clientY] : null;
    });
    canvas.addEventListener('pointerup', (e) => {
      // A drag turns the view; only a press without movement is a click.
      const still = this.down && Math.hypot(e.clientX - this.down[0], e.clientY - this.down[1]) < 5;
      if (this.active && still) this.click(e.offsetX, e.offsetY, e.pointerType === 'touch' ? touchRadius : clickRadius);
    });
  }

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }

  toggle(on = !this.active): void {
    this.active = on;
    this.pending = null;
    this.app.view.canvas.classList.toggle('measuring', on);
    this.changed('Click the first point.');
  }

  /** Esc: first gives up the begun length, then ends the mode. */
  escape(): void {
    if (this.pending) {
      this.pending = null;
      this.changed('Click the first point.');
    } else if (this.active) {
      this.toggle(false);
    }
  }

  remove(item: Measured): void {
    this.list.splice(this.list.indexOf(item), 1);
    if (item.known !== null) this.app.scaleFactors.delete(item.run);
    this.changed();
  }

  rename(item: Measured, name: string): void {
    item.name = name;
    this.changed();
  }

  /** Sets the scale of the run from a known length in meters; null takes it back. */
  setKnown(item: Measured, meters: number | null): void {
    for (const other of this.list) if (other.run === item.run) other.known = null;
    this.app.scaleFactors.delete(item.run);
    const scale = meters === null ? null : scaleFrom(item.measured, meters);
    if (scale) {
      item.known = meters;
      this.app.scaleFactors.set(item.run, scale);
    }
    this.changed();
    this.app.refresh();
  }

  private click(x: number, y: number, radius: number): void {
    const { matrix, width, height } = this.app.view.projection();
    const found = pick(shownCandidates(this.app), { matrix: matrix.elements, width, height }, x, y, radius);
    if (!found) return this.changed('There is no point near the click. Click on a point, or zoom in.');
    if (!this.pending) {
      this.pending = found;
      return this.changed('Click the second point. Esc gives this one up.');
    }
    const [a, b] = [this.pending, found];
    this.pending = null;
    if (a.run !== b.run) return this.changed('The two points are in different runs. Click two points of one run.');
    const scale = this.app.runs[a.run].scene.scale;
    const measured = lengthBetween(a, b, scale.kind === 'metric' ? scale.sigma : null);
    this.list.push({ name: `length ${this.list.length + 1}`, a, b, run: a.run, measured, known: null });
    this.changed('Measured. Click the first point of the next length, or Esc to end.');
  }

  private changed(hint?: string): void {
    if (hint !== undefined) this.hint.textContent = hint;
    this.hint.hidden = !this.active;
    for (const listener of this.listeners) listener();
    this.app.view.requestDraw();
  }
}
