// SPDX-License-Identifier: Apache-2.0
// A keyframe as the map knows it (its visual words, its depths), beside the place that it was matched with.
import { el } from '../ui/dom';
import { FeatureImage } from './feature_image';
import { FeatureLegend } from './feature_legend';
import type { LivePlace } from './messages';

export class PlaceView {
  private readonly own = new FeatureImage();
  private readonly matched = new FeatureImage(this.own.hidden);
  private readonly captions = [el('figcaption', { className: 'caption' }), el('figcaption', { className: 'caption' })];
  private readonly second = el('figure', { className: 'matched', hidden: true }, this.matched.canvas, this.captions[1]);
  private readonly legend: FeatureLegend;
  readonly element = el('div', { className: 'place', hidden: true, role: 'group', aria: { label: 'Place in the map' } });
  private shown: LivePlace | null = null;

  constructor() {
    this.own.canvas.setAttribute('aria-label', 'Image of the keyframe');
    this.matched.canvas.setAttribute('aria-label', 'Image of the matched place');
    this.legend = new FeatureLegend(this.own, () => this.matched.draw());
    const pictures = el('div', { className: 'pictures' }, el('figure', {}, this.own.canvas, this.captions[0]), this.second);
    this.element.append(pictures, this.legend.element);
  }

  show(place: LivePlace | null): void {
    if (place === this.shown) return;
    this.shown = place;
    this.element.hidden = place === null;
    this.second.hidden = !place?.matched;
    if (!place) return;
    const frame = `frame ${(place.image.index + 1).toLocaleString('en-US')}`;
    this.captions[0].textContent = place.keyframe >= 0 ? `keyframe ${place.keyframe}, ${frame}` : frame;
    this.captions[1].textContent = place.matched ? `matched place: keyframe ${place.matched.keyframe}` : '';
    this.own.show(place.image);
    this.matched.show(place.matched?.image ?? null);
    this.legend.show(place.image.colors ? null : place.image);
  }
}
