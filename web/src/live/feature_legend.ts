// SPDX-License-Identifier: Apache-2.0
// What the marks in the image mean, how many there are of each, and a switch for each.
import { el } from '../ui/dom';
import type { FeatureImage } from './feature_image';
import { drawShapes, featureStyle } from './feature_style';
import type { LiveImage } from './messages';

export class FeatureLegend {
  readonly element = el('div', { className: 'feature-legend', role: 'group', aria: { label: 'Features' } });
  private names = '';
  private counts: HTMLElement[] = [];

  /** `changed`: after a switch, for images beside this one. */
  constructor(private readonly image: FeatureImage, private readonly changed: () => void = () => {}) {}

  show(image: LiveImage | null): void {
    const names = image?.stateNames ?? [];
    // The same buttons stay while the names do: a click must not lose its button.
    if (names.join('|') !== this.names) this.build(names);
    const counts = new Array<number>(names.length).fill(0);
    for (const state of image?.states ?? []) if (state < counts.length) counts[state]++;
    this.counts.forEach((node, i) => (node.textContent = counts[i].toLocaleString('en-US')));
  }

  private build(names: string[]): void {
    this.names = names.join('|');
    this.counts = names.map(() => el('span', { className: 'count' }, '0'));
    this.element.replaceChildren(...names.map((name, i) => this.entry(name, i)));
  }

  private entry(name: string, i: number): HTMLElement {
    const node = el('button', { type: 'button', title: `Show or hide ${name} features`, aria: { pressed: `${!this.image.hidden.has(name)}` } },
      sample(name, i), el('span', {}, name.replaceAll('_', ' ')), this.counts[i]);
    node.onclick = () => {
      const shown = this.image.hidden.delete(name);
      if (!shown) this.image.hidden.add(name);
      node.setAttribute('aria-pressed', `${shown}`);
      this.image.draw();
      this.changed();
    };
    return node;
  }
}

/** The mark itself, drawn as in the image. */
function sample(name: string, i: number): HTMLCanvasElement {
  const canvas = el('canvas', { width: 32, height: 32, aria: { hidden: 'true' } });
  const context = canvas.getContext('2d')!;
  context.scale(2, 2);
  drawShapes(context, featureStyle(name, i), [8, 8], 4);
  return canvas;
}
