// SPDX-License-Identifier: Apache-2.0
// Keys. They act only where no control takes the key itself.
import type { App } from '../app';
import type { Actions, LiveActions } from './actions';

export function bindShortcuts(app: App, actions: Actions): void {
  const keys: Record<string, (event: KeyboardEvent) => void> = {
    f: actions.fit,
    a: actions.fromAbove,
    l: actions.toggleSide,
    t: actions.toggleTheme,
    m: actions.measure,
    x: actions.measureKind,
    Escape: actions.escape,
    s: actions.savePicture,
    b: actions.video,
    '?': actions.help,
    c: actions.lookFromFrame,
    v: actions.follow,
    ' ': actions.play,
    '[': () => actions.toEvent(-1),
    ']': () => actions.toEvent(1),
    ArrowLeft: (event) => actions.step(event.shiftKey ? -10 : -1),
    ArrowRight: (event) => actions.step(event.shiftKey ? 10 : 1),
    Home: () => actions.step(-Infinity),
    End: () => actions.step(Infinity),
    ...(actions.live ? liveKeys(actions.live) : {}),
  };
  window.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || takesKeys(event)) return;
    const action = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key] ?? layerKey(app, actions, event.key);
    if (!action) return;
    event.preventDefault();
    action(event);
  });
}

function liveKeys(live: LiveActions): Record<string, () => void> {
  const buttons = { p: 'pause', n: 'step', o: 'mapping', w: 'save', r: 'reset', e: 'end' };
  const presses = Object.entries(buttons).map(([key, name]) => [key, () => live.press(name)]);
  return { ...Object.fromEntries(presses), i: () => live.toggleFrameView(), g: () => live.follow() };
}

function layerKey(app: App, actions: Actions, key: string): (() => void) | null {
  if (!/^[1-9]$/.test(key)) return null;
  const layer = [...new Set(app.runs.flatMap((r) => r.layers.map((l) => l.key)))][Number(key) - 1];
  return layer ? () => actions.toggleLayer(layer) : null;
}

function takesKeys(event: KeyboardEvent): boolean {
  const target = event.target as HTMLElement;
  if (target.closest('dialog') && event.key !== '?') return true;
  if (target instanceof HTMLInputElement) return target.type !== 'checkbox' || event.key === ' ';
  if (target instanceof HTMLButtonElement) return event.key === ' ' || event.key === 'Enter';
  return target instanceof HTMLSelectElement || target.isContentEditable;
}
