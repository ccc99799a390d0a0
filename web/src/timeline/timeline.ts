// SPDX-License-Identifier: Apache-2.0
// The timeline below the view: buttons, speed, curve, and the strip to scrub in.
import type { App } from '../app';
import type { Frames, SceneEvent } from '../scene/scene';
import { button, el, select } from '../ui/dom';
import { icon, type IconName } from '../ui/icons';
import { digits, lengthText } from '../ui/units';
import { Player } from './player';
import { drawCursor, drawStrip, isMarked, stampToX, xToStamp, type StripData } from './strip';
import { curveLabels, duration, nearestFrame, type CurveName } from './track';

const stripHeight = 74;
const speeds = [0.25, 0.5, 1, 2, 4, 8, 16, 32];

export class Timeline {
  readonly element = el('footer', { className: 'timeline', aria: { label: 'Timeline' } });
  readonly player: Player;
  private readonly canvas = el('canvas', { tabIndex: 0, role: 'slider', aria: { label: 'Current frame' } });
  private readonly tip = el('div', { className: 'tip', hidden: true });
  private readonly clock = el('output', { className: 'clock' });
  private readonly play: HTMLButtonElement;
  private readonly controls = el('div', { className: 'controls' });
  private readonly background = document.createElement('canvas');
  private curve: CurveName | null = null;
  /** What the buttons and lists were made for. */
  private shown = '';
  private redrawTimer = 0;
  private redrawMs = 0;
  private scrubbing = false;
  private events: SceneEvent[] = [];

  constructor(private readonly app: App) {
    this.player = new Player(app, () => this.showPlaying());
    this.play = this.button('Play', 'play', 'Play (space)', () => this.player.toggle());
    this.bindPointer();
    app.onChange((changed) => {
      if (changed.has('active') || changed.has('frame')) this.clampFrame();
      if (changed.has('active') || changed.has('scene')) this.fill();
      else if (changed.has('frames')) this.grow();
      else if (changed.has('theme')) this.redraw();
      else if (changed.has('frame')) this.drawFrame();
    });
    new ResizeObserver(() => this.redraw()).observe(this.element);
    this.clampFrame();
    this.fill();
  }

  step(frames: number): void {
    this.player.go(this.app.state.frame + frames);
  }

  /** To the event before (-1) or after (1) the current frame. */
  toEvent(direction: -1 | 1): void {
    const at = this.app.state.frame;
    const rows = this.events.map((e) => e.frame!).filter((f) => (direction < 0 ? f < at : f > at)).sort((a, b) => a - b);
    if (rows.length) this.player.go(direction < 0 ? rows[rows.length - 1] : rows[0]);
  }

  /** A linked frame may lie behind the end of another run. */
  private clampFrame(): void {
    this.app.state.frame = Math.min(this.app.state.frame, Math.max(0, (this.app.frames?.count ?? 1) - 1));
  }

  /** Events with their place in the timeline; those without a frame take the frame nearest in time. */
  private findEvents(): SceneEvent[] {
    const { frames, active } = this.app;
    if (!frames || !active) return [];
    const marked = active.scene.events.filter((e) => isMarked(e.kind));
    return marked.map((e) => ({ ...e, frame: e.frame ?? nearestFrame(frames.stamps, e.stamp) }));
  }

  /** A run goes on: the strip is drawn anew as often as it can be without holding up the page. */
  private grow(): void {
    this.events = this.findEvents();
    if (this.shown === '') return this.fill();
    this.drawFrame();
    if (this.redrawTimer) return;
    const begin = performance.now() + Math.max(100, 10 * this.redrawMs);
    this.redrawTimer = window.setTimeout(() => {
      this.redrawTimer = 0;
      this.redraw();
    }, begin - performance.now());
  }

  private fill(): void {
    const { frames } = this.app;
    if (!frames) {
      this.shown = '';
      const live = this.app.active?.live ? 'The timeline begins with the first frame.' : 'This map has no trajectory, so there is no timeline.';
      const text = this.app.runs.length === 0 ? 'No map is shown.' : live;
      return this.element.replaceChildren(el('p', { className: 'missing' }, text));
    }
    this.events = this.findEvents();
    const curves = (Object.keys(curveLabels) as CurveName[]).filter((c) => frames[c]);
    // The same buttons stay while they suit: a list that is open would close.
    const shown = `${this.app.state.active} ${curves.join()} ${frames.states !== null}`;
    if (shown === this.shown) return this.redraw();
    this.shown = shown;
    if (!this.curve || !curves.includes(this.curve)) this.curve = curves[0] ?? null;
    this.controls.replaceChildren(
      this.button('Event before', 'previous', 'Event before ( [ )', () => this.toEvent(-1)),
      this.button('One frame back', 'back', 'One frame back (←)', () => this.step(-1)),
      this.play,
      this.button('One frame ahead', 'ahead', 'One frame ahead (→)', () => this.step(1)),
      this.button('Event after', 'next', 'Event after ( ] )', () => this.toEvent(1)),
      this.clock, this.speedSelect(), ...this.curveSelect(frames, curves));
    this.element.replaceChildren(this.controls, el('div', { className: 'strip' }, this.canvas, this.tip));
    this.redraw();
  }

  private button(label: string, name: IconName, title: string, onclick: () => void): HTMLButtonElement {
    return button(label, title, onclick, icon(name));
  }

  private speedSelect(): HTMLElement {
    const choices = speeds.map((s) => ({ value: `${s}`, label: `${s}×` }));
    return select('Speed', choices, `${this.player.speed}`, (value) => {
      this.player.speed = Number(value);
    });
  }

  private curveSelect(frames: Frames, curves: CurveName[]): HTMLElement[] {
    const gone = frames.states ? [] : [el('span', { className: 'missing' }, 'no states in this run')];
    if (curves.length === 0) return gone;
    const choices = curves.map((value) => ({ value, label: curveLabels[value] }));
    return [select('Curve', choices, this.curve!, (value) => {
      this.curve = value;
      this.redraw();
    }), ...gone];
  }

  private highest(values: Float32Array, name: CurveName): string {
    const top = values.reduce((a, b) => (b > a ? b : a), 0);
    return name === 'milliseconds' ? `${digits(top)} ms` : lengthText(this.app, top, null);
  }

  private showPlaying(): void {
    const playing = this.player.isPlaying;
    this.play.replaceChildren(icon(playing ? 'pause' : 'play'));
    this.play.setAttribute('aria-label', playing ? 'Pause' : 'Play');
    this.play.title = playing ? 'Pause (space)' : 'Play (space)';
  }

  /** The curve's largest value takes a pass over all frames: only where it is drawn. */
  private data(highest = ''): StripData {
    const { frames, active, dark, state } = this.app;
    return { frames: frames!, stateNames: active!.scene.stateNames, events: this.events, curve: this.curve, highest, frame: state.frame, dark };
  }

  /** The strip without the cursor is kept: moving the cursor over a long run stays cheap. */
  private redraw(): void {
    if (!this.app.frames) return;
    const begin = performance.now();
    const width = Math.max(50, this.element.clientWidth);
    const ratio = devicePixelRatio;
    for (const canvas of [this.canvas, this.background]) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(stripHeight * ratio);
    }
    const context = this.background.getContext('2d')!;
    context.scale(ratio, ratio);
    drawStrip(context, this.data(this.curve ? this.highest(this.app.frames[this.curve]!, this.curve) : ''), width, stripHeight);
    this.redrawMs = performance.now() - begin;
    this.drawFrame();
  }

  private drawFrame(): void {
    const { frames, state } = this.app;
    if (!frames) return;
    const context = this.canvas.getContext('2d')!;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    context.drawImage(this.background, 0, 0);
    context.scale(devicePixelRatio, devicePixelRatio);
    drawCursor(context, this.data(), this.element.clientWidth);
    const seconds = frames.stamps[state.frame] - frames.stamps[0];
    const all = duration(frames.stamps[frames.count - 1] - frames.stamps[0]);
    this.clock.replaceChildren(duration(seconds), el('span', { className: 'all' }, ` / ${all}`));
    const values = { valuemin: '0', valuemax: `${frames.count - 1}`, valuenow: `${state.frame}`, valuetext: `frame ${state.frame + 1} of ${frames.count}` };
    for (const [key, value] of Object.entries(values)) this.canvas.setAttribute(`aria-${key}`, value);
  }

  private bindPointer(): void {
    this.canvas.addEventListener('pointerdown', (event) => {
      this.scrubbing = true;
      this.canvas.setPointerCapture(event.pointerId);
      this.scrub(event);
    });
    this.canvas.addEventListener('pointermove', (event) => {
      if (this.scrubbing) this.scrub(event);
      this.showTip(event);
    });
    for (const end of ['pointerup', 'pointercancel'] as const) {
      this.canvas.addEventListener(end, () => {
        this.scrubbing = false;
      });
    }
    this.canvas.addEventListener('pointerleave', () => {
      this.tip.hidden = true;
    });
  }

  private scrub(event: PointerEvent): void {
    const { frames } = this.app;
    if (!frames) return;
    const near = event.offsetY < 16 ? this.eventNear(event.offsetX) : null;
    const stamp = near ? near.stamp : xToStamp(frames, event.offsetX, this.canvas.clientWidth);
    this.player.go(near?.frame ?? nearestFrame(frames.stamps, stamp));
  }

  private eventNear(x: number): SceneEvent | null {
    const { frames } = this.app;
    if (!frames) return null;
    const distance = (e: SceneEvent) => Math.abs(stampToX(frames, e.stamp, this.canvas.clientWidth) - x);
    const near = this.events.filter((e) => distance(e) < 8).sort((a, b) => distance(a) - distance(b));
    return near[0] ?? null;
  }

  private showTip(event: PointerEvent): void {
    const { frames, active } = this.app;
    if (!frames || !active) return;
    const near = this.eventNear(event.offsetX);
    const row = nearestFrame(frames.stamps, xToStamp(frames, event.offsetX, this.canvas.clientWidth));
    const state = frames.states ? active.scene.stateNames[frames.states[row]] : '';
    const time = duration(frames.stamps[row] - frames.stamps[0]);
    this.tip.textContent = near ? `${near.kind.replaceAll('_', ' ')}: ${near.detail || time}` : [time, state].filter((t) => t).join(' · ');
    this.tip.hidden = false;
    const width = this.canvas.clientWidth;
    this.tip.style.left = `${Math.min(Math.max(4, event.offsetX - this.tip.offsetWidth / 2), width - this.tip.offsetWidth - 4)}px`;
  }
}
