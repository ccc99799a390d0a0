// SPDX-License-Identifier: Apache-2.0
// How a feature is drawn: each state has a color and a shape of its own, so that either alone tells it.
import { okabeIto } from '../view3d/colors';

export type Shape = 'ring' | 'disc' | 'square' | 'cross' | 'triangle' | 'diamond' | 'dot';

export interface FeatureStyle {
  color: string;
  shape: Shape;
}

const known: Record<string, FeatureStyle> = {
  unmatched: { color: '#c4c9ce', shape: 'dot' },
  matched: { color: okabeIto.skyBlue, shape: 'square' },
  outlier: { color: okabeIto.vermillion, shape: 'cross' },
  inlier: { color: okabeIto.green, shape: 'disc' },
  new: { color: okabeIto.yellow, shape: 'triangle' },
  re_identified: { color: okabeIto.purple, shape: 'diamond' },
  corner: { color: okabeIto.yellow, shape: 'ring' },
  taken: { color: okabeIto.green, shape: 'disc' },
  // Visual words have the hues of Labbe and Michaud 2013, light and dark enough to be told apart by everyone.
  known_word: { color: '#d62f1f', shape: 'disc' },
  new_word: { color: '#35c24a', shape: 'triangle' },
  repeated_word: { color: '#ffe600', shape: 'square' },
  previous_word: { color: '#4a86ff', shape: 'ring' },
  shared_word: { color: '#ffb8f2', shape: 'diamond' },
};

const others: FeatureStyle[] = [
  { color: okabeIto.purple, shape: 'diamond' },
  { color: okabeIto.orange, shape: 'ring' },
  { color: okabeIto.blue, shape: 'square' },
];

export function featureStyle(name: string, place: number): FeatureStyle {
  return Object.hasOwn(known, name) ? known[name] : others[place % others.length];
}

type Context = CanvasRenderingContext2D;

function trace(context: Context, shape: Shape, x: number, y: number, r: number): void {
  switch (shape) {
    case 'square':
      return context.rect(x - r, y - r, 2 * r, 2 * r);
    case 'cross':
      context.moveTo(x - r, y - r);
      context.lineTo(x + r, y + r);
      context.moveTo(x - r, y + r);
      return context.lineTo(x + r, y - r);
    case 'triangle':
      return polygon(context, [x, y - 1.2 * r, x + 1.1 * r, y + r, x - 1.1 * r, y + r]);
    case 'diamond':
      return polygon(context, [x, y - 1.3 * r, x + 1.3 * r, y, x, y + 1.3 * r, x - 1.3 * r, y]);
    default: {
      const radius = shape === 'dot' ? 0.5 * r : r;
      context.moveTo(x + radius, y);
      return context.arc(x, y, radius, 0, 2 * Math.PI);
    }
  }
}

function polygon(context: Context, at: number[]): void {
  context.moveTo(at[0], at[1]);
  for (let i = 2; i < at.length; i += 2) context.lineTo(at[i], at[i + 1]);
  context.closePath();
}

/** All features of one state at once; a dark rim keeps them visible on any image. */
export function drawShapes(context: Context, style: FeatureStyle, points: ArrayLike<number>, radius: number): void {
  const filled = style.shape === 'disc' || style.shape === 'dot';
  context.beginPath();
  for (let i = 0; i + 1 < points.length; i += 2) trace(context, style.shape, points[i], points[i + 1], radius);
  context.lineJoin = 'round';
  context.strokeStyle = 'rgba(0, 0, 0, .7)';
  context.lineWidth = filled ? 2 : 3;
  context.stroke();
  context.strokeStyle = context.fillStyle = style.color;
  context.lineWidth = 1.5;
  if (filled) context.fill();
  else context.stroke();
}
