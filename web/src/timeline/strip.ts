// SPDX-License-Identifier: Apache-2.0
// Draws the timeline: marks of events, band of states (color and pattern), a curve, the time axis, the current frame.
import type { Frames, SceneEvent } from '../scene/scene';
import { loopColor, okabeIto, stateColor } from '../view3d/colors';
import { columnMaxima, duration, stretches, timeStep, type CurveName } from './track';

export interface StripData {
  frames: Frames;
  stateNames: string[];
  events: SceneEvent[];
  curve: CurveName | null;
  /** Largest value of the curve, as text. */
  highest: string;
  frame: number;
  dark: boolean;
}

export const margin = 12;
const rows = { events: 2, band: 16, bandHeight: 12, curve: 32, curveHeight: 24, axis: 58 };

type Context = CanvasRenderingContext2D;

export function stampToX(frames: Frames, stamp: number, width: number): number {
  const [first, last] = [frames.stamps[0], frames.stamps[frames.count - 1]];
  return margin + ((stamp - first) / Math.max(last - first, 1e-9)) * (width - 2 * margin);
}

export function xToStamp(frames: Frames, x: number, width: number): number {
  const [first, last] = [frames.stamps[0], frames.stamps[frames.count - 1]];
  const share = Math.min(1, Math.max(0, (x - margin) / (width - 2 * margin)));
  return first + share * (last - first);
}

export function drawStrip(context: Context, data: StripData, width: number, height: number): void {
  context.clearRect(0, 0, width, height);
  drawBand(context, data, width);
  drawCurve(context, data, width);
  drawAxis(context, data, width);
  drawEvents(context, data, width);
}

/** Short states (a loss of three frames in an hour) stay at least two pixels wide and lie above the long ones. */
function drawBand(context: Context, data: StripData, width: number): void {
  const all = stretches(data.frames);
  const usual = (state: number) => state < 0 || data.stateNames[state] === 'tracking';
  for (const stretch of [...all.filter((s) => usual(s.state)), ...all.filter((s) => !usual(s.state))]) {
    const x = stampToX(data.frames, stretch.from, width);
    const w = Math.max(usual(stretch.state) ? 1 : 2, stampToX(data.frames, stretch.to, width) - x);
    const name = stretch.state < 0 ? '' : data.stateNames[stretch.state];
    context.fillStyle = stateColor(name);
    context.fillRect(x, rows.band, w, rows.bandHeight);
    drawPattern(context, name, x, w);
  }
}

/** Patterns tell the states apart without colors. */
function drawPattern(context: Context, name: string, x: number, w: number): void {
  if (name === 'tracking' || name === '') return;
  context.save();
  context.beginPath();
  context.rect(x, rows.band, w, rows.bandHeight);
  context.clip();
  context.strokeStyle = context.fillStyle = 'rgba(0, 0, 0, .55)';
  context.beginPath();
  const [top, bottom] = [rows.band, rows.band + rows.bandHeight];
  for (let at = Math.floor(x / 5) * 5 - 15; at < x + w; at += 5) {
    if (name === 'lost') line(context, at, bottom, at + rows.bandHeight, top);
    if (name === 'relocalized') line(context, at, top, at, bottom);
    if (name === 'weak') for (const y of [top + 3, top + 8]) context.rect(at, y, 1.5, 1.5);
    if (name === 'initializing') line(context, at, top + 6, at + 5, top + 6);
  }
  context.stroke();
  context.restore();
}

function line(context: Context, x0: number, y0: number, x1: number, y1: number): void {
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
}

function drawCurve(context: Context, data: StripData, width: number): void {
  const values = data.curve ? data.frames[data.curve] : null;
  if (!values) return;
  const maxima = columnMaxima(data.frames, values, Math.max(1, Math.floor((width - 2 * margin) / 2)));
  const top = maxima.reduce((a, b) => (b > a ? b : a), 0) || 1;
  const y = (value: number) => rows.curve + rows.curveHeight * (1 - value / top);
  context.strokeStyle = data.dark ? '#8fa1b3' : '#5d6975';
  context.lineWidth = 1.2;
  context.beginPath();
  let open = false;
  maxima.forEach((value, i) => {
    if (Number.isNaN(value)) return;
    const x = margin + 2 * i + 1;
    if (open) context.lineTo(x, y(value));
    else context.moveTo(x, y(value));
    open = true;
  });
  context.stroke();
  drawHighest(context, data);
}

/** The curve's largest value, at its upper left corner. */
function drawHighest(context: Context, data: StripData): void {
  context.font = '11px system-ui, "DejaVu Sans", sans-serif';
  context.textBaseline = 'top';
  context.fillStyle = data.dark ? 'rgba(26, 31, 38, .8)' : 'rgba(246, 247, 249, .8)';
  context.fillRect(margin + 4, rows.curve, context.measureText(data.highest).width + 4, 12);
  context.fillStyle = data.dark ? '#98a5b3' : '#5d6975';
  context.fillText(data.highest, margin + 6, rows.curve);
}

function drawAxis(context: Context, data: StripData, width: number): void {
  const { stamps, count } = data.frames;
  const span = stamps[count - 1] - stamps[0];
  const step = timeStep(span, Math.max(2, Math.floor(width / 110)));
  context.fillStyle = data.dark ? '#98a5b3' : '#5d6975';
  context.strokeStyle = data.dark ? '#2e3742' : '#dde2e7';
  context.lineWidth = 1;
  context.font = '11px system-ui, "DejaVu Sans", sans-serif';
  context.textBaseline = 'top';
  for (let t = 0; t <= span + 1e-9; t += step) {
    const x = Math.round(stampToX(data.frames, stamps[0] + t, width)) + 0.5;
    context.beginPath();
    line(context, x, rows.band + rows.bandHeight, x, rows.axis);
    context.stroke();
    const text = step < 1 ? `${t.toFixed(1)} s` : duration(t).replace(/\.00 s$/, ' s').replace(/\.0$/, '');
    const left = Math.min(x, width - context.measureText(text).width - 4);
    context.fillText(text, t === 0 ? x : left - (left < x ? 0 : context.measureText(text).width / 2), rows.axis);
  }
}

/** Each frame's state is in the band, and keyframes and revisions are too many: what remains is worth a mark. */
export function isMarked(kind: string): boolean {
  return !['keyframe', 'map_revised', 'tracking', 'weak', 'initializing'].includes(kind);
}

export type Mark = 'loop' | 'loss' | 'other';

export function markOf(kind: string): Mark {
  return /loop|merge/.test(kind) ? 'loop' : /lost|loss|fail/.test(kind) ? 'loss' : 'other';
}

/** A triangle for a loop, a cross for a loss, a dot for the rest. */
function drawEvents(context: Context, data: StripData, width: number): void {
  for (const event of data.events) {
    const x = stampToX(data.frames, event.stamp, width);
    if (x < 0 || x > width) continue;
    const [kind, y] = [markOf(event.kind), rows.events + 6];
    context.lineWidth = 2;
    context.strokeStyle = context.fillStyle = kind === 'loop' ? loopColor : kind === 'loss' ? okabeIto.vermillion : okabeIto.skyBlue;
    context.beginPath();
    if (kind === 'loop') {
      context.moveTo(x - 5, y - 4);
      context.lineTo(x + 5, y - 4);
      context.lineTo(x, y + 5);
      context.fill();
    } else if (kind === 'loss') {
      line(context, x - 4, y - 4, x + 4, y + 4);
      line(context, x - 4, y + 4, x + 4, y - 4);
      context.stroke();
    } else {
      context.arc(x, y, 3, 0, 2 * Math.PI);
      context.fill();
    }
  }
}

export function drawCursor(context: Context, data: StripData, width: number): void {
  const x = Math.round(stampToX(data.frames, data.frames.stamps[data.frame], width));
  context.fillStyle = data.dark ? '#fff' : '#000';
  context.fillRect(x - 1, rows.band - 3, 2, rows.axis - rows.band + 2);
  context.beginPath();
  context.arc(x, rows.band - 3, 4, 0, 2 * Math.PI);
  context.fill();
}
