// SPDX-License-Identifier: Apache-2.0
// The panel with the current frame of a recording, which is fetched when it becomes the current one.
import type { App } from '../app';
import { FeatureImage } from '../live/feature_image';
import { FeatureLegend } from '../live/feature_legend';
import { SceneError } from '../scene/scene';
import { el } from '../ui/dom';
import { stateColor } from '../view3d/colors';
import { readFrameBlock, type RecordedFrame } from './frame_block';
import { FramePoints } from './frame_points';

export class RecordingView {
  readonly element = el('details', { className: 'frame-view', open: innerWidth > 720, aria: { label: 'Frame view' } });
  private readonly image = new FeatureImage();
  private readonly title = el('summary', { title: 'Image of the current frame' });
  private readonly pictures = el('div', { className: 'pictures', hidden: true });
  private readonly line = el('p', { className: 'facts-line' });
  private readonly legend = new FeatureLegend(this.image);
  private readonly points: FramePoints;
  private shown = '';
  private busy = false;

  /** `recordings`: numbers of scenes on the server, by run; `query` carries the token. */
  constructor(private readonly app: App, private readonly recordings: Map<number, number>, private readonly query: string) {
    this.points = new FramePoints(app);
    this.pictures.append(el('figure', {}, this.image.canvas));
    this.element.append(this.title, this.pictures, this.legend.element, this.line);
    this.element.classList.toggle('whole', !app.frames?.positions.some(Number.isFinite));
    this.image.onDrawn = (image) => (this.element.dataset.image = `${image.index}`);
    app.onChange((changed) => {
      if (changed.has('frame') || changed.has('active')) void this.update();
      if (changed.has('hiddenRuns')) this.points.update();
    });
    void this.update();
  }

  toggle(): void {
    this.element.open = !this.element.open;
  }

  /** Never two fetches at once: while one is on its way the newest frame waits, and those between are left out. */
  private async update(): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    try {
      let wanted = this.wanted();
      for (; wanted !== null && wanted.path !== this.shown; wanted = this.wanted()) {
        this.shown = wanted.path;
        const frame = await this.fetched(wanted.path);
        // Its pose is looked up in the run that is shown now.
        if (this.wanted()?.scene === wanted.scene) this.show(frame, wanted.frame);
      }
      if (wanted === null) this.forget();
    } finally {
      this.busy = false;
    }
  }

  /** The run that is shown is no recording. */
  private forget(): void {
    this.shown = '';
    this.points.hide();
  }

  private wanted(): { scene: number; path: string; frame: number } | null {
    const { state, frames } = this.app;
    const scene = this.recordings.get(state.active);
    this.element.hidden = scene === undefined;
    if (scene === undefined || !frames) return null;
    return { scene, path: `/api/frame/${scene}/${state.frame}${this.query}`, frame: state.frame };
  }

  /** A text says why there is none. */
  private async fetched(path: string): Promise<RecordedFrame | string> {
    try {
      const response = await fetch(path);
      if (!response.ok) return (await response.text()).slice(0, 200);
      return readFrameBlock(new Uint8Array(await response.arrayBuffer()));
    } catch (error) {
      return error instanceof SceneError ? error.message : 'the server of rastro view does not answer; is it still running?';
    }
  }

  private show(frame: RecordedFrame | string, row: number): void {
    const count = (n: number) => n.toLocaleString('en-US');
    this.title.textContent = `Frame ${count(row + 1)} of ${count(this.app.frames?.count ?? 0)}`;
    this.element.dataset.frame = `${row}`;
    const state = stateOf(this.app, row);
    if (state !== '') this.title.append(el('span', { className: 'key' }, el('span', { className: 'swatch', style: `background:${stateColor(state)}` }), state));
    if (typeof frame === 'string') {
      // What another frame showed must not be taken for this one.
      this.pictures.hidden = true;
      this.image.show(null);
      delete this.element.dataset.image;
      this.legend.show(null);
      this.points.hide();
      this.line.textContent = frame;
      return;
    }
    this.pictures.hidden = frame.image === null;
    this.image.show(frame.image);
    this.legend.show(frame.image);
    this.points.show(frame, row);
    const features = frame.image?.states.length ?? 0;
    const facts = [frame.name, frame.points.length ? `${count(frame.points.length / 3)} points measured` : '', features ? `${count(features)} features` : ''];
    this.line.textContent = facts.filter((t) => t !== '').join(' · ');
  }
}

/** Empty where the run says nothing of the frame. */
function stateOf(app: App, row: number): string {
  const states = app.frames?.states;
  return states ? app.active?.scene.stateNames[states[row]] ?? '' : '';
}
