// SPDX-License-Identifier: Apache-2.0
// Small helpers to build elements. Text is always set as text, never as HTML: names come from files of other people.

type Props<T> = Partial<Omit<T, 'style' | 'dataset'>> & { style?: string; data?: Record<string, string>; aria?: Record<string, string> };

export function el<K extends keyof HTMLElementTagNameMap>(
  tag: K, props: Props<HTMLElementTagNameMap[K]> = {}, ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const node = document.createElement(tag);
  const { style, data, aria, ...rest } = props;
  Object.assign(node, rest);
  if (style) node.style.cssText = style;
  for (const [key, value] of Object.entries(data ?? {})) node.dataset[key] = value;
  for (const [key, value] of Object.entries(aria ?? {})) node.setAttribute(`aria-${key}`, value);
  node.append(...children);
  return node;
}

export function button(label: string, title: string, onclick: () => void, ...children: (Node | string)[]): HTMLButtonElement {
  const node = el('button', { type: 'button', title, onclick }, ...(children.length ? children : [label]));
  node.setAttribute('aria-label', label);
  return node;
}

export function section(title: string, ...children: (Node | string)[]): HTMLElement {
  return el('section', { aria: { label: title } }, el('h2', {}, title), ...children);
}

export interface Choice<T extends string> {
  value: T;
  label: string;
  disabled?: boolean;
}

export function select<T extends string>(label: string, choices: Choice<T>[], value: T, onchange: (value: T) => void): HTMLElement {
  const node = el('select', { aria: { label }, onchange: () => onchange(node.value as T) });
  for (const choice of choices) {
    node.append(el('option', { value: choice.value, disabled: choice.disabled ?? false, selected: choice.value === value }, choice.label));
  }
  return el('label', { className: 'field' }, el('span', {}, label), node);
}

export interface SliderOptions {
  label: string;
  min: number;
  max: number;
  step: number;
  value: number;
  format: (value: number) => string;
  oninput: (value: number) => void;
}

export function slider(options: SliderOptions): HTMLElement {
  const { label, min, max, step, value, format, oninput } = options;
  const shown = el('output', {}, format(value));
  const input = el('input', { type: 'range', min: `${min}`, max: `${max}`, step: `${step}`, aria: { label } });
  input.value = `${value}`;
  input.oninput = () => {
    shown.textContent = format(Number(input.value));
    oninput(Number(input.value));
  };
  return el('label', { className: 'field slider' }, el('span', {}, label), input, shown);
}

export function checkbox(label: string, detail: string, checked: boolean, onchange: (on: boolean) => void): HTMLElement {
  const input = el('input', { type: 'checkbox', checked, onchange: () => onchange(input.checked) });
  return el('label', { className: 'check', title: label }, input, el('span', { className: 'name' }, label), el('span', { className: 'detail' }, detail));
}
