// SPDX-License-Identifier: Apache-2.0
// Asks before something that cannot be taken back. The first button, which has the focus, leaves all as it is.
import { el } from '../ui/dom';

export function ask(title: string, text: string, yes: string): Promise<boolean> {
  const dialog = el('dialog', { className: 'ask', aria: { label: title } });
  const close = (value: string) => () => dialog.close(value);
  dialog.append(el('h2', {}, title), el('p', {}, text), el('div', { className: 'answers' },
    el('button', { type: 'button', autofocus: true, onclick: close('') }, 'Cancel'),
    el('button', { type: 'button', className: 'danger', onclick: close('yes') }, yes)));
  document.body.append(dialog);
  dialog.showModal();
  return new Promise((done) => {
    dialog.addEventListener('close', () => {
      dialog.remove();
      done(dialog.returnValue === 'yes');
    });
  });
}
