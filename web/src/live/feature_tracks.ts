// SPDX-License-Identifier: Apache-2.0
// Where features were in the frames before, and their ids.
import { featureStyle } from './feature_style';
import type { LiveImage } from './messages';

/** As many ids can be read side by side. */
const fewFeatures = 30;
const longestJump = 0.25;

type Context = CanvasRenderingContext2D;

function isHidden(image: LiveImage, hidden: Set<string>, i: number): boolean {
  return hidden.has(image.stateNames[image.states[i]] ?? '');
}

/** One line for each feature, in the color of its state; a dark rim keeps it visible on any image. */
export function drawTrails(context: Context, image: LiveImage, hidden: Set<string>, scale: number): void {
  if (image.trails.length === 0) return;
  image.stateNames.forEach((name, state) => {
    if (hidden.has(name)) return;
    context.beginPath();
    image.trails.forEach((trail, i) => {
      if (image.states[i] === state) trace(context, trail, scale, longestJump * image.width);
    });
    context.lineJoin = 'round';
    context.strokeStyle = 'rgba(0, 0, 0, .55)';
    context.lineWidth = 3;
    context.stroke();
    context.strokeStyle = featureStyle(name, state).color;
    context.lineWidth = 1.25;
    context.stroke();
  });
}

/** A place that is none, or far from the one before, begins a new line. */
function trace(context: Context, trail: Float32Array, scale: number, longest: number): void {
  let [lastX, lastY] = [NaN, NaN];
  for (let k = 0; k + 1 < trail.length; k += 2) {
    const [x, y] = [trail[k], trail[k + 1]];
    if (Math.hypot(x - lastX, y - lastY) <= longest) context.lineTo(x * scale, y * scale);
    else if (Number.isFinite(x) && Number.isFinite(y)) context.moveTo(x * scale, y * scale);
    [lastX, lastY] = [x, y];
  }
}

/** The id of the feature under the pointer, or all of them where they are few. */
export function drawIds(context: Context, image: LiveImage, hidden: Set<string>, scale: number, hovered: number): void {
  const { ids, features } = image;
  if (!ids) return;
  context.font = '600 11px system-ui, sans-serif';
  context.textBaseline = 'middle';
  for (let i = 0; i < ids.length; i++) {
    if (ids[i] < 0 || isHidden(image, hidden, i) || (i !== hovered && ids.length > fewFeatures)) continue;
    const [x, y, text] = [features[2 * i] * scale, features[2 * i + 1] * scale, `${ids[i]}`];
    const width = context.measureText(text).width;
    const left = x + 8 + width > image.width * scale ? x - 8 - width : x + 8;
    context.fillStyle = i === hovered ? '#000' : 'rgba(0, 0, 0, .6)';
    context.fillRect(left - 2, y - 7, width + 4, 14);
    context.fillStyle = '#fff';
    context.fillText(text, left, y);
  }
}
