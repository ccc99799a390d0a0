// SPDX-License-Identifier: Apache-2.0
// The keyframe in which the current frame was recognized, beside the frame's own image.
import { el } from '../ui/dom';
import type { LiveImage } from './messages';

export class MatchedPlace {
  private readonly image = el('img', { alt: 'Matched place', onerror: () => (this.image.hidden = true) });
  private readonly caption = el('figcaption', { className: 'caption' });
  readonly element = el('figure', { className: 'matched', hidden: true }, this.image, this.caption);
  private shown: LiveImage['matched'] = null;

  show(matched: LiveImage['matched']): void {
    if (matched === this.shown) return;
    this.shown = matched;
    URL.revokeObjectURL(this.image.src);
    this.element.hidden = matched === null;
    if (!matched) return;
    this.image.hidden = false;
    this.image.src = URL.createObjectURL(new Blob([matched.jpeg as BlobPart], { type: 'image/jpeg' }));
    this.caption.textContent = `matched: keyframe ${matched.keyframe}`;
  }
}
