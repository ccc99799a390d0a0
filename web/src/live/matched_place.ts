// SPDX-License-Identifier: Apache-2.0
// The keyframe in which the current frame was recognized, beside the frame's own image.
// Often only one image of many has one: during a run it stays for a while, or nobody could look at it.
import { el } from '../ui/dom';
import type { LiveImage } from './messages';

const holdMs = 4000;

export class MatchedPlace {
  private readonly image = el('img', { alt: 'Matched place', onerror: () => (this.image.hidden = true) });
  private readonly caption = el('figcaption', { className: 'caption' });
  readonly element = el('figure', { className: 'matched', hidden: true }, this.image, this.caption);
  private shown: LiveImage['matched'] = null;
  private since = 0;

  /** `hold`: the page follows the run. */
  show(image: LiveImage | null, hold: boolean): void {
    const matched = image?.matched ?? null;
    if (matched) this.since = performance.now();
    if (matched === this.shown || (!matched && hold && performance.now() - this.since < holdMs)) return;
    this.shown = matched;
    URL.revokeObjectURL(this.image.src);
    this.element.hidden = matched === null;
    if (!image || !matched) return;
    this.image.hidden = false;
    this.image.src = URL.createObjectURL(new Blob([matched.jpeg as BlobPart], { type: 'image/jpeg' }));
    this.caption.textContent = `keyframe ${matched.keyframe}, matched by frame ${image.index + 1}`;
  }
}
