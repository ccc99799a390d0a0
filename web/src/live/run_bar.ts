// SPDX-License-Identifier: Apache-2.0
// The bar above the timeline: how the run goes on, what can be asked of it, and the way back to the newest frame.
import { button, el } from '../ui/dom';
import { digits } from '../ui/units';
import type { LiveFrame } from './messages';
import { RunControls } from './run_controls';
import type { LiveSession } from './session';

export class RunBar {
  readonly element = el('div', { className: 'run-bar', aria: { label: 'Run' } });
  readonly controls: RunControls;
  private readonly state = el('span', { className: 'run-state', role: 'status' });
  private readonly facts = el('span', { className: 'run-facts' });
  private readonly fault = el('span', { className: 'run-fault', hidden: true });
  private readonly retry: HTMLButtonElement;
  private readonly live: HTMLButtonElement;

  constructor(private readonly session: LiveSession) {
    this.controls = new RunControls(session);
    this.retry = button('Try again', 'Connect to the run once more', () => session.connection.retry());
    this.live = button('Live', 'Follow the newest frame (G)', () => session.follow());
    this.live.className = 'live';
    this.element.append(this.state, this.retry, this.controls.element, this.fault, this.facts, this.live);
    session.onNews(() => this.show());
    this.show();
  }

  private show(): void {
    const { session } = this;
    const [kind, text] = stateOf(session);
    if (this.state.textContent !== text) this.state.replaceChildren(el('span', { className: 'dot' }), text);
    this.state.dataset.kind = kind;
    this.retry.hidden = session.link !== 'gone';
    this.live.setAttribute('aria-pressed', `${session.following}`);
    this.live.hidden = session.record.count === 0;
    if (session.newest) this.facts.textContent = factsOf(session.newest, session.hello?.frames ?? null);
    const { count, line } = session.unreadable;
    this.fault.hidden = count === 0;
    this.fault.textContent = `${count.toLocaleString('en-US')} unreadable`;
    this.fault.title = `${count} messages of the run could not be read. The last: ${line}`;
  }
}

/** What the run does, in words; the kind gives the color. */
function stateOf({ link, status, newest }: LiveSession): [string, string] {
  if (link === 'gone') return ['gone', "the run's program has ended"];
  if (link === 'lost') return ['lost', 'connection lost, trying again'];
  if (link === 'connecting') return ['lost', 'connecting'];
  const line = status?.line ? `: ${status.line}` : '';
  if (status?.ended) return ['ended', `run ended${line}`];
  if (status?.paused) return ['paused', `paused${line}`];
  return ['open', `${newest ? 'running' : 'waiting for the first frame'}${line}`];
}

function factsOf(frame: LiveFrame, all: number | null): string {
  const count = (n: number) => n.toLocaleString('en-US');
  const done = frame.done ?? frame.index + 1;
  const parts = [
    all ? `${count(done)} of ${count(all)} frames` : `${count(done)} frames`,
    frame.rate !== null ? `${digits(frame.rate)} / s` : '',
    frame.memoryMb !== null ? `${count(Math.round(frame.memoryMb))} MB` : '',
    frame.dropped > 0 ? `${count(frame.dropped)} not sent` : '',
  ];
  return parts.filter((p) => p !== '').join(' · ');
}
