// SPDX-License-Identifier: Apache-2.0
// The list of lengths: those named in the map, and those measured here.
import type { App } from '../app';
import type { NamedLength } from '../scene/scene';
import { button, checkbox, el } from '../ui/dom';
import { icon } from '../ui/icons';
import { lengthOf, measuredOf } from './texts';
import type { Measure, Measured } from './measure';

export class LengthList {
  readonly element = el('details', { className: 'lengths', open: innerWidth > 720, aria: { label: 'Lengths' } });
  private readonly title = el('summary');
  private readonly rows = el('div', { className: 'rows' });

  constructor(private readonly app: App, private readonly measure: Measure) {
    this.element.append(this.title, this.rows);
    measure.onChange(() => this.fill());
    app.onChange((changed) => {
      if (changed.has('layers') || changed.has('theme')) this.fill();
    });
    this.fill();
  }

  private fill(): void {
    const named = this.app.runs.flatMap((run) => run.scene.lengths.map((l) => ({ run: run.index, l })));
    this.element.hidden = named.length + this.measure.list.length === 0;
    this.title.textContent = `Lengths (${named.length + this.measure.list.length})`;
    // A field in which the person writes must not be replaced under the cursor.
    if (this.rows.contains(document.activeElement) && document.activeElement instanceof HTMLInputElement && document.activeElement.type !== 'checkbox') document.activeElement.blur();
    const show = named.length
      ? [checkbox('Named lengths in the view', '', this.app.state.layers.lengths ?? true, (on) => this.app.setLayer('lengths', on))]
      : [];
    this.rows.replaceChildren(...show, ...named.map(({ run, l }) => this.named(run, l)), ...this.measure.list.map((item) => this.measured(item)));
  }

  private named(run: number, length: NamedLength): HTMLElement {
    const text = lengthOf(this.app, length, run);
    return el('div', { className: 'length' }, el('span', { className: 'name' }, length.name || 'unnamed'), el('span', { className: 'value' }, text));
  }

  private measured(item: Measured): HTMLElement {
    const name = el('input', { type: 'text', value: item.name, aria: { label: 'Name of the length' } });
    name.onchange = () => this.measure.rename(item, name.value);
    const remove = button('Remove', 'Remove this length', () => this.measure.remove(item), icon('close'));
    const title = `from ${item.a.kind} in ${item.a.source} to ${item.b.kind} in ${item.b.source}`;
    const row = el('div', { className: 'length', title }, name, el('span', { className: 'value' }, measuredOf(this.app, item)), remove);
    const below = [
      ...(item.note ? [el('div', { className: 'note' }, item.note)] : []),
      ...(this.app.runs[item.run].scene.scale.kind === 'arbitrary' ? [this.known(item)] : []),
    ];
    return below.length ? el('div', {}, row, ...below) : row;
  }

  private known(item: Measured): HTMLElement {
    const input = el('input', { type: 'number', min: '0', step: 'any', placeholder: 'm', aria: { label: 'Known length in meters' } });
    if (item.known !== null) input.value = `${item.known}`;
    input.onchange = () => this.measure.setKnown(item, Number(input.value) > 0 ? Number(input.value) : null);
    return el('label', { className: 'known', title: 'Sets the scale of this map: all lengths are shown in meters' }, el('span', {}, 'known length [m]'), input);
  }
}
