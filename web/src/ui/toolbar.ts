// SPDX-License-Identifier: Apache-2.0
// The bar at the top: what is shown, and what can be done with the view.
import type { App } from '../app';
import type { Scene } from '../scene/scene';
import type { Actions } from './actions';
import { button, el } from './dom';
import { icon, type IconName } from './icons';
import { isMapless } from './missing';
import { titleOf } from './layout';

export function toolbar(app: App, actions: Actions): HTMLElement {
  const menu = tool('Layers', 'menu', 'Layers and colors (L)', actions.toggleSide);
  menu.classList.add('menu');
  return el('header', { className: 'bar' },
    menu,
    el('h1', { title: titleOf(app) }, titleOf(app)),
    el('div', { className: 'facts' }, ...facts(app)),
    el('div', { className: 'tools', role: 'toolbar', aria: { label: 'View' } },
      tool('Fit', 'fit', 'Show the whole map (F)', actions.fit),
      tool('Above', 'above', 'Look from above (A)', actions.fromAbove),
      tool('Measure', 'measure', 'Measure a length by two clicks (M)', actions.measure),
      tool('Picture', 'picture', 'Save the view as a PNG picture (S)', actions.savePicture),
      tool('Video', 'video', 'Save a video, or end it (B)', actions.video),
      tool('Theme', 'theme', 'Dark or light (T)', actions.toggleTheme),
      tool('Help', 'help', 'Keys and mouse (?)', actions.help)));
}

/** After another map of the run came. */
export function showTitle(app: App, bar: HTMLElement): void {
  const title = bar.querySelector('h1')!;
  title.title = title.textContent = titleOf(app);
  bar.querySelector('.facts')!.replaceChildren(...facts(app));
}

function tool(label: string, name: IconName, title: string, onclick: () => void): HTMLButtonElement {
  const node = button(label, title, onclick, icon(name), el('span', {}, label));
  node.dataset.tool = label.toLowerCase();
  return node;
}

function facts(app: App): HTMLElement[] {
  if (app.runs.length !== 1) return [el('span', {}, `${app.runs.length} runs`)];
  const { scene, live } = app.runs[0];
  if (live && isMapless(scene)) return [scene.method, 'no map yet'].filter((t) => t !== '').map((t) => el('span', {}, t));
  const texts = [scene.method, scene.revision !== null ? `revision ${scene.revision}` : '', scaleText(scene), sessionsText(scene)];
  return texts.filter((t) => t !== '').map((t) => el('span', {}, t));
}

export function scaleText(scene: Scene): string {
  const { kind, sigma, origin } = scene.scale;
  if (kind === 'arbitrary') return 'arbitrary scale';
  const parts = [sigma !== null && sigma > 0 ? `± ${Number((100 * sigma).toPrecision(2))} %` : '', origin ? `from ${origin}` : ''];
  return ['metric scale', ...parts.filter((p) => p)].join(' ');
}

function sessionsText(scene: Scene): string {
  return scene.sessions.length > 1 ? `${scene.sessions.length} sessions` : '';
}
