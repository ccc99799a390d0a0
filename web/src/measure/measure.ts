// SPDX-License-Identifier: Apache-2.0
// Measuring by two clicks: the mode, the measured lengths, and the hint what to do next.
import * as THREE from 'three';
import type { App } from '../app';
import { button, el } from '../ui/dom';
import { shownCandidates } from './candidates';
import { featureAt, spanBetween, type Feature, type FeatureKind, type Span } from './feature';
import { scaleFrom, type Length } from './length';
import { pick, type Picked } from './pick';
import { askServer } from './server_measure';

export interface Measured {
  name: string;
  a: Feature;
  b: Feature;
  /** Ends of the drawn line. */
  ends: Pick<Span, 'a' | 'b'>;
  run: number;
  /** In the unit of the run's map. */
  measured: Length;
  /** Entered by the person, in meters; the run's scale comes from it. */
  known: number | null;
  /** By what, and what the program doubts; for the person. */
  note: string;
}

const clickRadius = 14;
const touchRadius = 26;
/** Around a click on an edge or a face, points within this many pixels are looked at, but in a metric map at most so many meters. */
const surroundings = 45;
const [leastMeters, mostMeters] = [0.06, 0.2];

const kinds: FeatureKind[] = ['point', 'edge', 'face'];
const article: Record<FeatureKind, string> = { point: 'a point', edge: 'a point near an edge', face: 'a face' };

export class Measure {
  readonly list: Measured[] = [];
  private readonly text = el('span');
  private readonly buttons = kinds.map((kind) => button(kind, `Clicks take ${kind}s (X changes)`, () => this.setKind(kind)));
  readonly hint = el('p', { className: 'hint', role: 'status', hidden: true },
    el('span', { className: 'kinds', role: 'group', aria: { label: 'What a click takes' } }, ...this.buttons), this.text);
  pending: Feature | null = null;
  active = false;
  kind: FeatureKind = 'point';
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
    this.setKind('point');
    app.onChange((changed) => {
      if (changed.has('forgotten') && app.live) this.forget(app.live.run);
    });
  }

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }

  toggle(on = !this.active): void {
    this.active = on;
    this.pending = null;
    this.app.view.canvas.classList.toggle('measuring', on);
    this.changed(this.invitation());
  }

  /** What the next clicks take. */
  setKind(kind: FeatureKind): void {
    this.kind = kind;
    this.buttons.forEach((b, i) => b.setAttribute('aria-pressed', `${kinds[i] === kind}`));
    if (this.active) this.changed(this.invitation());
  }

  nextKind(): void {
    if (this.active) this.setKind(kinds[(kinds.indexOf(this.kind) + 1) % kinds.length]);
  }

  /** Esc: first gives up the begun length, then ends the mode. */
  escape(): void {
    if (this.pending) {
      this.pending = null;
      this.changed(this.invitation());
    } else if (this.active) {
      this.toggle(false);
    }
  }

  remove(item: Measured): void {
    this.list.splice(this.list.indexOf(item), 1);
    if (item.known === null) return this.changed();
    this.app.scaleFactors.delete(item.run);
    this.changed();
    this.app.refresh();
  }

  /** The map of a run that these lengths were measured in is no more. */
  private forget(run: number): void {
    this.list.splice(0, this.list.length, ...this.list.filter((item) => item.run !== run));
    if (this.pending?.run === run) this.pending = null;
    this.changed(this.invitation());
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

  private invitation(): string {
    return this.pending ? `Now click ${article[this.kind]} at the other end. Esc gives this one up.` : `Click ${article[this.kind]} at one end of the length.`;
  }

  private click(x: number, y: number, radius: number): void {
    const { matrix, width, height } = this.app.view.projection();
    const picked = pick(shownCandidates(this.app), { matrix: matrix.elements, width, height }, x, y, radius);
    if (!picked) return this.changed('There is no point near the click. Click on a point, or zoom in.');
    const found = featureAt(this.kind, picked, this.around(picked));
    if (!found) return this.changed(this.kind === 'edge' ? 'The points around the click end in no straight edge. Zoom in, or measure points.' : 'The points around the click lie on no flat face. Zoom in, or measure points.');
    if (!this.pending) {
      this.pending = found;
      return this.changed(this.invitation());
    }
    if (this.pending.run !== found.run) return this.changed('The two ends are in different runs. Click both in one run.');
    this.finish(this.pending, found);
  }

  private around(picked: Picked) {
    const { scene } = this.app.runs[picked.run];
    const { camera, canvas } = this.app.view;
    const depth = camera.position.distanceTo(new THREE.Vector3(...picked.point));
    const perPixel = (2 * depth * Math.tan(THREE.MathUtils.degToRad(camera.fov / 2))) / Math.max(1, canvas.clientHeight);
    const metric = scene.scale.kind === 'metric';
    const radius = metric ? Math.min(mostMeters, Math.max(leastMeters, surroundings * perPixel)) : surroundings * perPixel;
    return { candidates: shownCandidates(this.app), radius, perPixel, metric, upright: scene.planar ? scene.up : null };
  }

  private finish(a: Feature, b: Feature): void {
    const { scale } = this.app.runs[a.run].scene;
    const span = spanBetween(a, b, scale.kind === 'metric' ? scale.sigma : null);
    if (!span) return this.changed('The two ends are not parallel: between them there is no length. Click another one, or Esc.');
    this.pending = null;
    const item: Measured = {
      name: `length ${this.list.length + 1}`, a, b, ends: span, run: a.run, measured: { length: span.length, sigma: span.sigma }, known: null,
      note: a.kind === 'point' && b.kind === 'point' ? '' : 'from the points of the map',
    };
    this.list.push(item);
    this.changed('Measured. Click the first end of the next length, or Esc to end.');
    void this.refine(item);
  }

  /** The program measures edges and faces in the images of the map, where it is there and has them. */
  private async refine(item: Measured): Promise<void> {
    const url = this.app.measureUrls[item.run] ?? null;
    const answer = url === null ? null : await askServer(url, item.a, item.b);
    if (!answer) return;
    if (answer.problem !== null) {
      item.note = `from the points of the map; in the images: ${answer.problem}`;
    } else {
      Object.assign(item, { ends: answer.span, measured: { length: answer.span.length, sigma: answer.span.sigma } });
      item.note = `from the images of the keyframes${answer.note ? `; ${answer.note}` : ''}`;
    }
    if (this.list.includes(item)) this.changed();
  }

  private changed(hint?: string): void {
    if (hint !== undefined) this.text.textContent = hint;
    this.hint.hidden = !this.active;
    for (const listener of this.listeners) listener();
    this.app.view.requestDraw();
  }
}
