// SPDX-License-Identifier: Apache-2.0
// Colors that color-blind people can tell apart: Okabe and Ito's palette for kinds, viridis and cividis for values.

export type Rgb = [number, number, number];
export type MapName = 'viridis' | 'cividis';
export type Range = [number, number];

export const okabeIto = {
  orange: '#e69f00',
  skyBlue: '#56b4e9',
  green: '#009e73',
  yellow: '#f0e442',
  blue: '#0072b2',
  vermillion: '#d55e00',
  purple: '#cc79a7',
  gray: '#8f8f8f',
} as const;

/** Loops have one color in the view and in the timeline. */
export const loopColor = okabeIto.purple;

/** One color a run, in the order of the runs. */
export const runColors: string[] = [
  okabeIto.skyBlue,
  okabeIto.orange,
  okabeIto.green,
  okabeIto.vermillion,
  okabeIto.blue,
  okabeIto.yellow,
];

const stateColors: Record<string, string> = {
  tracking: okabeIto.green,
  weak: okabeIto.orange,
  lost: okabeIto.vermillion,
  relocalized: okabeIto.skyBlue,
  // Of a board in front of a camera that is being calibrated.
  taken: okabeIto.green,
  moving: okabeIto.orange,
  no_board: okabeIto.vermillion,
  one_camera: okabeIto.skyBlue,
  nothing_new: '#a5a5a5',
  initializing: '#a5a5a5', // the palette's own gray is too near to its green without red or green cones
};

export function stateColor(name: string): string {
  return Object.hasOwn(stateColors, name) ? stateColors[name] : okabeIto.gray;
}

// Ten equally spaced colors of each map; between them the color is interpolated.
const stops: Record<MapName, string[]> = {
  viridis: ['440154', '482878', '3e4a89', '31688e', '26828e', '1f9e89', '35b779', '6dcd59', 'b4de2c', 'fde725'],
  cividis: ['00204d', '00336f', '39486b', '575c6d', '707173', '8a8779', 'a69d75', 'c4b56c', 'e4cf5b', 'ffea46'],
};

export function hexToRgb(hex: string): Rgb {
  const value = parseInt(hex.replace('#', ''), 16);
  return [((value >> 16) & 255) / 255, ((value >> 8) & 255) / 255, (value & 255) / 255];
}

const tables: Record<MapName, Rgb[]> = {
  viridis: stops.viridis.map(hexToRgb),
  cividis: stops.cividis.map(hexToRgb),
};

/** Color of a share in [0, 1]; values outside are clamped, NaN is gray. */
export function mapColor(map: MapName, share: number): Rgb {
  if (Number.isNaN(share)) return hexToRgb(okabeIto.gray);
  const table = tables[map];
  const place = Math.min(1, Math.max(0, share)) * (table.length - 1);
  const below = Math.min(table.length - 2, Math.floor(place));
  const part = place - below;
  const [a, b] = [table[below], table[below + 1]];
  return [a[0] + (b[0] - a[0]) * part, a[1] + (b[1] - a[1]) * part, a[2] + (b[2] - a[2]) * part];
}

export function shareOf(value: number, range: Range): number {
  return range[1] > range[0] ? (value - range[0]) / (range[1] - range[0]) : 0.5;
}

/** 256 colors as RGBA bytes, for a texture. */
export function mapBytes(map: MapName): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(256 * 4);
  for (let i = 0; i < 256; i++) {
    const rgb = mapColor(map, i / 255);
    for (let c = 0; c < 3; c++) bytes[4 * i + c] = Math.round(rgb[c] * 255);
    bytes[4 * i + 3] = 255;
  }
  return bytes;
}

/** The same map for a legend, from left (low) to right (high). */
export function mapGradient(map: MapName): string {
  return `linear-gradient(to right, ${stops[map].map((s) => `#${s}`).join(', ')})`;
}

/** Range without the outermost two percent, so that a few outliers do not take all the color; null without values. */
export function robustRange(values: Iterable<number>): Range | null {
  const sorted = Float64Array.from([...values].filter(Number.isFinite)).sort();
  if (sorted.length === 0) return null;
  const at = (share: number) => sorted[Math.round(share * (sorted.length - 1))];
  return sorted.length < 50 ? [sorted[0], sorted[sorted.length - 1]] : [at(0.02), at(0.98)];
}

export function joinRanges(ranges: (Range | null)[]): Range | null {
  const known = ranges.filter((r): r is Range => r !== null);
  if (known.length === 0) return null;
  return [Math.min(...known.map((r) => r[0])), Math.max(...known.map((r) => r[1]))];
}
