// SPDX-License-Identifier: Apache-2.0
// Icons as strokes on a field of 16 by 16.

const paths = {
  menu: 'M2 4h12M2 8h12M2 12h12',
  fit: 'M2 6V2h4M10 2h4v4M14 10v4h-4M6 14H2v-4M6 8h4M8 6v4',
  above: 'M2 8l6-4 6 4-6 4zM8 1v6M6 5l2 2 2-2',
  measure: 'M1.5 10.5l9-9 4 4-9 9zM4 8l1.5 1.5M6.5 5.5L8.500 7.500M9 3l1.500 1.500',
  picture: 'M2 5h3l1-2h4l1 2h3v8H2zM8 6.500a2.500 2.500 0 1 0 .01 0',
  video: 'M1.500 4h8.500v8H1.500zM10 8l4.500-3v6z',
  link: 'M6.500 9.500l3-3M7 4.500l1.500-1.500a3 3 0 0 1 4.500 4.500L11.500 9M9 11.500L7.500 13a3 3 0 0 1-4.500-4.500L4.500 7',
  theme: 'M8 2a6 6 0 1 0 .01 0M8 2v12M8 5l4-1M8 8h6M8 11l4 1',
  help: 'M8 1.500a6.500 6.500 0 1 0 .01 0M6 6.200a2 2 0 1 1 2.600 1.900c-.4.2-.6.5-.6 1.100M8 11.500v.3',
  play: 'M4 2.500v11l9-5.500z',
  pause: 'M5 3v10M11 3v10',
  back: 'M10.500 3v10L4 8z',
  ahead: 'M5.500 3v10L12 8z',
  previous: 'M12 3v10L6 8zM4 3v10',
  next: 'M4 3v10l6-5zM12 3v10',
  camera: 'M2 4.500h8v7H2zM10 7l4-2v6l-4-2',
  stop: 'M3.5 3.5h9v9h-9z',
  reset: 'M3 8a5 5 0 1 0 1.600-3.700M3 2.500v3h3',
  save: 'M8 2v8M4.500 7L8 10.500 11.500 7M2.500 13.500h11',
  pin: 'M8 14.500s4.500-4.300 4.500-8a4.500 4.500 0 1 0-9 0c0 3.700 4.500 8 4.500 8zM8 5a1.500 1.500 0 1 0 .01 0',
  map: 'M1.500 4l4.500-1.500 4 1.500 4.500-1.500v10L10 14l-4-1.500L1.500 14zM6 2.500v10M10 4v10',
  close: 'M4 4l8 8M12 4l-8 8',
} as const;

export type IconName = keyof typeof paths;

export function icon(name: IconName): SVGElement {
  const ns = 'http://www.w3.org/2000/svg';
  const svg = document.createElementNS(ns, 'svg');
  svg.setAttribute('viewBox', '0 0 16 16');
  svg.setAttribute('class', 'icon');
  svg.setAttribute('aria-hidden', 'true');
  const path = document.createElementNS(ns, 'path');
  path.setAttribute('d', paths[name]);
  svg.append(path);
  return svg;
}
