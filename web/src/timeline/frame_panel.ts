// SPDX-License-Identifier: Apache-2.0
// The panel with the values of the current frame, and the image of the keyframe nearest in time.
import type { App } from '../app';
import type { Frames, Scene, Thumbnail } from '../scene/scene';
import { stateColor } from '../view3d/colors';
import { button, el } from '../ui/dom';
import { icon } from '../ui/icons';
import { digits, lengthText } from '../ui/units';
import type { CurrentFrame } from './current_frame';
import { isMarked } from './strip';
import { duration } from './track';

export class FramePanel {
  readonly element = el('details', { className: 'frame', open: innerWidth > 720, aria: { label: 'Current frame' } });
  private readonly title = el('summary');
  private readonly list = el('dl');
  private readonly image = el('img', { alt: 'Image of the nearest keyframe', hidden: true, onerror: () => (this.image.hidden = true) });
  private shownImage: Thumbnail | null = null;

  constructor(private readonly app: App, current: CurrentFrame) {
    const look = button('Look from this camera', 'Look from the camera of this frame (C)', () => current.look(), icon('camera'), 'Look from here');
    const follow = button('Follow', 'Move the view along with the current frame (V)', () => current.setFollow(!current.follow), 'Follow');
    current.onFollow(() => follow.setAttribute('aria-pressed', `${current.follow}`));
    this.element.append(this.title, this.image, this.list, el('div', { className: 'buttons' }, look, follow));
    app.onChange(() => this.fill());
    this.fill();
  }

  private fill(): void {
    const { frames, active, state } = this.app;
    this.element.hidden = !frames;
    if (!frames || !active) return;
    // During a run the frame view names the frame.
    this.title.textContent = active.live ? 'Pose and values' : `Frame ${(state.frame + 1).toLocaleString('en-US')} of ${frames.count.toLocaleString('en-US')}`;
    const rows = frameRows(this.app, frames, active.scene, state.frame);
    this.list.replaceChildren(...rows.flatMap(([name, value]) => [el('dt', {}, name), el('dd', {}, value)]));
    this.showImage(nearestImage(active.scene, frames.stamps[state.frame]));
  }

  private showImage(image: Thumbnail | null): void {
    if (image === this.shownImage) return;
    this.shownImage = image;
    URL.revokeObjectURL(this.image.src);
    this.image.hidden = image === null;
    if (image) this.image.src = URL.createObjectURL(new Blob([image.jpeg as BlobPart], { type: 'image/jpeg' }));
    else this.image.removeAttribute('src');
  }
}

type Row = [string, Node | string];

function frameRows(app: App, frames: Frames, scene: Scene, row: number): Row[] {
  const rows: Row[] = [['Stamp', `${frames.stamps[row].toFixed(3)} s`]];
  if (frames.states) rows.push(['State', stateCell(scene.stateNames[frames.states[row]])]);
  const length = (values: Float32Array | null) => (values && Number.isFinite(values[row]) ? lengthText(app, values[row], null) : 'unknown');
  if (frames.sigmas) rows.push(['Sigma', length(frames.sigmas)]);
  if (frames.errors) rows.push(['Error', length(frames.errors)]);
  if (frames.milliseconds) rows.push(['Processing', Number.isFinite(frames.milliseconds[row]) ? `${digits(frames.milliseconds[row])} ms` : 'unknown']);
  const p = [...frames.positions.subarray(3 * row, 3 * row + 3)].map((v) => v.toFixed(2));
  rows.push(['Position', p.join('  ')]);
  const why = reason(scene, frames.stamps[row]);
  if (why) rows.push(['Reason', why]);
  const event = lastEvent(scene, frames.stamps[row]);
  if (event && !(why && event.endsWith(why))) rows.push(['Last event', event]);
  return rows;
}

function stateCell(name: string): Node {
  return el('span', { className: 'key' }, el('span', { className: 'swatch', style: `background:${stateColor(name)}` }), name);
}

/** Why the state is as it is: the last event of a state, unless all is well again. */
function reason(scene: Scene, now: number): string | null {
  const last = scene.events.findLast((e) => e.stamp <= now + 1e-6 && scene.stateNames.includes(e.kind));
  const bad = last && ['weak', 'lost', 'initializing'].includes(last.kind);
  return bad && last.detail !== '' && last.detail !== 'none' ? last.detail : null;
}

/** The last event with a mark in the timeline, if it is not long ago. */
function lastEvent(scene: Scene, now: number): string | null {
  const last = scene.events.findLast((e) => e.stamp <= now + 1e-6 && isMarked(e.kind));
  if (!last || now - last.stamp > 3) return null;
  const ago = now - last.stamp;
  return `${last.kind.replaceAll('_', ' ')}${ago > 0.01 ? ` ${duration(ago)} ago` : ''}${last.detail ? `: ${last.detail}` : ''}`;
}

function nearestImage(scene: Scene, stamp: number): Thumbnail | null {
  let best: Thumbnail | null = null;
  let distance = Infinity;
  for (const image of scene.images) {
    const d = Math.abs(scene.keyframes!.stamps[image.keyframe] - stamp);
    if (d < distance) [best, distance] = [image, d];
  }
  return best;
}
