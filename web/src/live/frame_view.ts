// SPDX-License-Identifier: Apache-2.0
// The panel with the image of the current frame: features by state, matched place, stage times, and why tracking fails.
import type { App } from '../app';
import { stateColor } from '../view3d/colors';
import { el } from '../ui/dom';
import { digits, lengthText } from '../ui/units';
import { CalibrationView } from './calibration_view';
import { FeatureImage } from './feature_image';
import { FeatureLegend } from './feature_legend';
import { PlaceView } from './place_view';
import type { Calibration, LiveFrame, LiveImage } from './messages';
import type { LiveSession, News } from './session';

/** An image of a frame so near is not told apart: images come less often than frames. */
const nearFrames = 8;

export class FrameView {
  readonly element = el('details', { className: 'frame-view', open: innerWidth > 720, aria: { label: 'Frame view' } });
  readonly image = new FeatureImage();
  private readonly title = el('summary', { title: 'Image and features of the current frame (I)' });
  private readonly caption = el('p', { className: 'caption' });
  private readonly pictures = el('div', { className: 'pictures', hidden: true });
  private readonly figure = el('figure', {});
  private readonly facts = el('p', { className: 'facts-line' });
  private readonly trouble = el('div', { className: 'trouble', role: 'status', hidden: true });
  private readonly stages = el('div', { className: 'stages' });
  private readonly legend: FeatureLegend;
  private readonly place = new PlaceView();
  private readonly calibration: CalibrationView;
  private readonly empty = el('p', { className: 'missing' });

  constructor(private readonly app: App, private readonly session: LiveSession) {
    this.legend = new FeatureLegend(this.image);
    this.calibration = new CalibrationView(this.image);
    this.figure.append(this.image.canvas, this.caption);
    this.pictures.append(this.figure, this.calibration.element);
    this.element.append(this.title, this.trouble, this.pictures, this.empty, this.legend.element, this.place.element, this.facts, this.stages);
    this.image.onDrawn = (image) => (this.element.dataset.image = `${image.index}`);
    app.onChange((changed) => {
      if (changed.has('frame') || changed.has('frames')) this.fill();
    });
    session.onNews((news) => {
      if (news.has('hello')) this.element.classList.toggle('whole', session.hello?.poses === false);
      if (news.has('calibration') && session.calibration) this.showCalibration(session.calibration);
      if (['image', 'place', 'hello', 'calibration'].some((each) => news.has(each as News))) this.fill();
    });
    this.element.addEventListener('toggle', () => this.fill());
    this.fill();
  }

  toggle(): void {
    this.element.open = !this.element.open;
  }

  private showCalibration(calibration: Calibration): void {
    // Of a calibration there is nothing to see but this, also where there is little room.
    if (!this.element.classList.contains('calibrating')) this.element.open = true;
    this.element.classList.add('calibrating');
    this.calibration.show(calibration);
  }

  private fill(): void {
    const { record } = this.session;
    const row = this.app.state.frame;
    const frame = record.details[row] ?? null;
    const state = record.frames ? record.stateNames[record.frames.states![row]] ?? '' : '';
    this.element.dataset.frame = frame ? `${frame.index}` : '';
    this.title.replaceChildren(...titleOf(frame, state, this.session.hello?.frames ?? null));
    // A closed panel costs nothing but its title.
    if (!this.element.open) return;
    this.showImage(this.imageOf(frame), frame);
    this.showTrouble(frame, state);
    this.facts.replaceChildren(...(frame ? factsOf(this.app, frame, this.session.hello?.poses !== false) : []));
    this.stages.replaceChildren(...(frame ? stageBars(frame) : []));
  }

  /** While the page follows the run, the newest image is the one to see, although frames are ahead of it. */
  private imageOf(frame: LiveFrame | null): LiveImage | null {
    const { images, following } = this.session;
    return following ? images.last : frame && images.near(frame.index);
  }

  private showImage(image: LiveImage | null, frame: LiveFrame | null): void {
    // What a calibration lacks is shown before the first image too.
    this.pictures.hidden = image === null && this.session.calibration === null;
    this.figure.hidden = image === null;
    this.empty.hidden = image !== null;
    this.empty.textContent = frame ? 'No image of this frame was sent.' : 'No frame yet.';
    this.image.show(image);
    this.legend.show(image);
    const { following, places } = this.session;
    this.place.show(following ? places.at(-1) ?? null : places.findLast((p) => frame !== null && p.image.index <= frame.index) ?? null);
    const apart = image && frame ? Math.abs(frame.index - image.index) : 0;
    this.caption.textContent = image && apart > nearFrames ? `image of frame ${(image.index + 1).toLocaleString('en-US')}` : '';
  }

  private showTrouble(frame: LiveFrame | null, state: string): void {
    const bad = frame !== null && ['weak', 'lost', 'initializing'].includes(state);
    this.trouble.hidden = !bad;
    if (!bad) return;
    this.trouble.style.borderColor = stateColor(state);
    const why = frame.reason && frame.reason !== 'none' ? frame.reason.replaceAll('_', ' ') : '';
    const parts = [el('b', {}, [words[state], why].filter((t) => t).join(': '))];
    if (frame.detail) parts.push(el('span', {}, frame.detail));
    if (frame.advice) parts.push(el('span', { className: 'advice' }, frame.advice));
    this.trouble.replaceChildren(...parts);
  }
}

const words: Record<string, string> = { weak: 'Tracking is weak', lost: 'Tracking lost', initializing: 'Initializing' };

function titleOf(frame: LiveFrame | null, state: string, all: number | null): (Node | string)[] {
  if (!frame) return ['Frame view'];
  const count = frame.index + 1;
  const of = all ? ` of ${all.toLocaleString('en-US')}` : '';
  const swatch = el('span', { className: 'swatch', style: `background:${stateColor(state)}` });
  return [`Frame ${count.toLocaleString('en-US')}${of}`, el('span', { className: 'key' }, swatch, state.replaceAll('_', ' '))];
}

function factsOf(app: App, frame: LiveFrame, poses: boolean): HTMLElement[] {
  const texts = [
    frame.used !== null ? `${frame.used.toLocaleString('en-US')} tracked` : '',
    frame.score !== null ? `score ${digits(frame.score)}` : '',
    frame.sigma !== null ? `sigma ${lengthText(app, frame.sigma, null)}` : '',
    frame.pose === null && poses ? 'no pose' : '',
  ];
  return texts.filter((t) => t !== '').map((t) => el('span', {}, t));
}

/** Stages as bars; the longest bar is the whole frame. */
function stageBars(frame: LiveFrame): HTMLElement[] {
  const sum = frame.stages.reduce((total, [, ms]) => total + ms, 0);
  const whole = Math.max(frame.ms ?? 0, sum, 1e-9);
  const bar = (name: string, ms: number, kind: string) => [
    el('span', { className: 'name' }, name.replaceAll('_', ' ')),
    el('span', { className: 'track' }, el('span', { className: kind, style: `width:${((100 * ms) / whole).toFixed(1)}%` })),
    el('span', { className: 'value' }, `${digits(ms)} ms`),
  ];
  const total = frame.ms !== null ? bar('whole frame', frame.ms, 'fill whole') : [];
  return [...frame.stages.flatMap(([name, ms]) => bar(name, ms, 'fill')), ...total];
}
