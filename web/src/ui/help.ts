// SPDX-License-Identifier: Apache-2.0
// Keys and mouse in one table.
import { button, el } from './dom';
import { icon } from './icons';

const rows: [string, string][] = [
  ['drag / one finger', 'turn the view'],
  ['right drag / two fingers', 'move the view'],
  ['wheel / pinch', 'zoom to the pointer'],
  ['F', 'show the whole map'],
  ['A', 'look from above'],
  ['C', 'look from the camera of the current frame'],
  ['V', 'follow the current frame, or stop'],
  ['M', 'measure: click both ends; Esc ends'],
  ['X', 'measure points, edges or faces'],
  ['space', 'play or pause'],
  ['← →', 'one frame back or ahead; with Shift ten'],
  ['Home End', 'first or last frame'],
  ['[ ]', 'event before or after'],
  ['1 … 9', 'switch a layer, in the order of the list'],
  ['L', 'show or hide the panel of layers'],
  ['T', 'dark or light'],
  ['S', 'save the view as a picture (PNG)'],
  ['B', 'save a video of a turn, or of the timeline'],
  ['?', 'this help'],
];

const liveRows: [string, string][] = [
  ['P', 'pause the run, or resume it'],
  ['N', 'next frame of a paused run'],
  ['O', 'localization only, or mapping again'],
  ['W', 'save the map'],
  ['R', 'reset the map (asks first)'],
  ['E', 'end the run (asks first)'],
  ['G', 'follow the newest frame'],
  ['I', 'show or hide the frame view'],
];

export function helpDialog(live: boolean): HTMLDialogElement {
  const dialog = el('dialog', { className: 'help', aria: { label: 'Keys and mouse' } });
  const table = el('table', {}, ...[...rows, ...(live ? liveRows : [])].map(([key, text]) => el('tr', {}, el('td', {}, el('kbd', {}, key)), el('td', {}, text))));
  dialog.append(
    el('div', { className: 'row' }, el('h2', {}, 'Keys and mouse'), button('Close', 'Close (Esc)', () => dialog.close(), icon('close'))),
    table,
    el('p', {}, 'Axes of the world: x red-orange, y green, z blue. In the timeline: triangle a loop, cross a loss, dot another event; above the curve its largest value.'),
    el('p', {}, 'The address of this page holds the view, the layers, the colors and the frame: copy it to link what you see.'));
  dialog.addEventListener('click', (event) => {
    if (event.target === dialog) dialog.close();
  });
  return dialog;
}
