// SPDX-License-Identifier: Apache-2.0
// What can be asked of the run. A button shows what the run says of itself, never what was asked of it.
import { button, el } from '../ui/dom';
import { icon, type IconName } from '../ui/icons';
import { ask } from './ask';
import type { Command } from './messages';
import type { LiveSession } from './session';

/** So long a button shows that the run has not answered yet. */
const answerMs = 4000;

interface Control {
  node: HTMLButtonElement;
  /** What a press asks for by now; null: nothing. */
  command: () => Command | null;
  /** Shown on the button by now. */
  label: () => [string, IconName];
}

export class RunControls {
  readonly element = el('div', { className: 'run-buttons', role: 'toolbar', aria: { label: 'Run' } });
  private readonly controls: Record<string, Control>;
  private waiting = 0;

  constructor(private readonly session: LiveSession) {
    this.controls = {
      pause: this.control('P', () => (this.paused ? 'resume' : 'pause'), () => (this.paused ? ['Resume', 'play'] : ['Pause', 'pause'])),
      // One frame more makes sense only where the run stands still.
      step: this.control('N', () => (this.paused ? 'step' : null), () => ['Step', 'next']),
      mapping: this.control('O', () => this.mappingCommand(), () => (this.session.status?.mapping === false ? ['Resume mapping', 'map'] : ['Localization only', 'pin'])),
      save: this.control('W', () => 'save', () => ['Save map', 'save']),
      reset: this.control('R', () => 'reset', () => ['Reset', 'reset']),
      end: this.control('E', () => 'end', () => [this.calibrates ? 'Calibrate now' : 'End', 'stop']),
    };
    this.element.append(...Object.values(this.controls).map((c) => c.node));
    session.onNews((news) => {
      if (news.has('status')) this.answered();
      if (news.has('link') || news.has('hello') || news.has('status')) this.show();
    });
    this.show();
  }

  /** A button was pressed, or its key. */
  async press(name: string): Promise<void> {
    const { node } = this.controls[name];
    if (node.hidden || node.disabled) return;
    if (name === 'reset' && !(await ask('Reset the map?', 'The map so far is saved beside the results, and the run goes on with an empty one.', 'Reset'))) return;
    if (name === 'end' && !(await this.askForEnd())) return;
    const command = this.controls[name].command();
    if (command && this.session.send(command)) this.wait(node);
  }

  private askForEnd(): Promise<boolean> {
    if (this.calibrates) return ask('Calibrate now?', 'No further view is taken. The camera is calibrated from those taken so far.', 'Calibrate');
    return ask('End the run?', 'No further frame is processed. The map and the results are written as at the end of the data.', 'End the run');
  }

  private get calibrates(): boolean {
    return this.session.hello?.method === 'calibrate';
  }

  private get paused(): boolean {
    return this.session.status?.paused === true;
  }

  private mappingCommand(): Command | null {
    const mapping = this.session.status?.mapping ?? null;
    return mapping === null ? null : mapping ? 'mapping_off' : 'mapping_on';
  }

  private control(key: string, command: Control['command'], label: Control['label']): Control {
    const node = button('', '', () => void this.press(Object.keys(this.controls).find((name) => this.controls[name].node === node)!));
    node.dataset.key = key;
    return { node, command, label };
  }

  private show(): void {
    const { hello, link, status } = this.session;
    for (const [name, { node, command, label }] of Object.entries(this.controls)) {
      const [text, picture] = label();
      const asked = command();
      node.hidden = !hello || ![...hello.commands].some((c) => c === name || c.startsWith(`${name}_`)) || (name === 'mapping' && status !== null && status.mapping === null);
      node.disabled = link !== 'open' || asked === null || !hello?.commands.has(asked) || status?.ended === true;
      node.dataset.command = asked ?? '';
      if (node.getAttribute('aria-label') === text) continue;
      node.setAttribute('aria-label', text);
      node.title = `${text} (${node.dataset.key})`;
      node.replaceChildren(icon(picture), el('span', {}, text));
    }
  }

  private wait(node: HTMLButtonElement): void {
    node.setAttribute('aria-busy', 'true');
    clearTimeout(this.waiting);
    this.waiting = window.setTimeout(() => this.answered(), answerMs);
  }

  private answered(): void {
    clearTimeout(this.waiting);
    for (const { node } of Object.values(this.controls)) node.removeAttribute('aria-busy');
  }
}
