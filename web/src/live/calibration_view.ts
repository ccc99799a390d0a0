// SPDX-License-Identifier: Apache-2.0
// The assistant of a calibration: where to hold the board next, and what of the image and of tilts was shown so far.
import { okabeIto } from '../view3d/colors';
import { el } from '../ui/dom';
import type { FeatureImage } from './feature_image';
import type { Calibration, Coverage, LiveImage } from './messages';

type Context = CanvasRenderingContext2D;

export class CalibrationView {
  readonly element = el('section', { className: 'calibration', hidden: true, aria: { label: 'Calibration' } });
  private readonly next = el('p', { className: 'next', role: 'status' });
  private readonly views = el('div', { className: 'gauge' });
  private readonly tilts = el('div', { className: 'tilts' });
  private readonly missing = el('ul', { className: 'lacking', aria: { label: 'Missing' } });
  private calibration: Calibration | null = null;

  constructor(private readonly image: FeatureImage) {
    this.element.append(this.next, this.views, this.tilts, this.missing, key());
    image.underFeatures = (context, shown, scale) => this.draw(context, shown, scale);
  }

  show(calibration: Calibration): void {
    this.calibration = calibration;
    this.element.hidden = false;
    this.element.classList.toggle('enough', calibration.enough);
    // Read aloud only where it says something else.
    if (this.next.textContent !== calibration.line) this.next.textContent = calibration.line;
    this.views.replaceChildren(...gauge('views taken', calibration.views, calibration.enoughViews, ''));
    this.tilts.replaceChildren(...calibration.cameras.flatMap((camera) => tiltGauges(camera, calibration.wantedTilt)));
    this.missing.replaceChildren(...(calibration.missing.length ? calibration.missing.map((name) => el('li', {}, name)) : [el('li', { className: 'none' }, 'nothing is missing')]));
    this.image.draw();
  }

  /** Over the image of each camera: what is covered, the boards taken, and the parts where the board is wanted. */
  private draw(context: Context, image: LiveImage, scale: number): void {
    if (!this.calibration) return;
    const { cameras, outlines } = this.calibration;
    const width = (image.width * scale) / cameras.length;
    cameras.forEach((camera, k) => drawCells(context, camera.seen, k * width, width, image.height * scale, fillSeen));
    context.strokeStyle = 'rgba(255, 255, 255, .55)';
    context.lineWidth = 1;
    for (const outline of outlines) drawOutline(context, outline, scale);
    cameras.forEach((camera, k) => drawCells(context, camera.missing, k * width, width, image.height * scale, markMissing));
  }
}

type DrawCell = (context: Context, x: number, y: number, width: number, height: number) => void;

function drawCells(context: Context, cells: boolean[], left: number, width: number, height: number, draw: DrawCell): void {
  const side = Math.sqrt(cells.length);
  cells.forEach((is, k) => {
    if (is) draw(context, left + ((k % side) * width) / side, (Math.floor(k / side) * height) / side, width / side, height / side);
  });
}

const fillSeen: DrawCell = (context, x, y, width, height) => {
  context.fillStyle = 'rgba(0, 158, 115, .22)';
  context.fillRect(x, y, width, height);
};

const markMissing: DrawCell = (context, x, y, width, height) => {
  context.fillStyle = 'rgba(230, 159, 0, .16)';
  context.fillRect(x, y, width, height);
  context.strokeStyle = okabeIto.orange;
  context.lineWidth = 2;
  context.setLineDash([6, 4]);
  context.strokeRect(x + 3, y + 3, width - 6, height - 6);
  context.setLineDash([]);
};

function drawOutline(context: Context, outline: number[], scale: number): void {
  context.beginPath();
  for (let i = 0; i + 1 < outline.length; i += 2) context.lineTo(outline[i] * scale, outline[i + 1] * scale);
  context.closePath();
  context.stroke();
}

/** Either of two opposite tilts is enough. */
function tiltGauges({ name, tilts }: Coverage, wanted: number): HTMLElement[] {
  const of = name ? `${name}: ` : '';
  const [left, right, up, down] = tilts.map((tilt) => Math.max(0, Math.round(tilt)));
  return [
    el('div', { className: 'gauge' }, ...gauge(`${of}tilt left or right`, Math.max(left, right), wanted, '°')),
    el('div', { className: 'gauge' }, ...gauge(`${of}tilt up or down`, Math.max(up, down), wanted, '°')),
  ];
}

function gauge(name: string, value: number, wanted: number, unit: string): HTMLElement[] {
  const share = Math.min(1, value / Math.max(1, wanted));
  const bar = el('span', { className: share < 1 ? 'fill' : 'fill full', style: `width:${(100 * share).toFixed(1)}%` });
  return [el('span', { className: 'name' }, name), el('span', { className: 'value' }, `${value}${unit} of ${wanted}${unit}`), el('span', { className: 'track' }, bar)];
}

function key(): HTMLElement {
  const entry = (kind: string, text: string) => el('span', {}, el('span', { className: `patch ${kind}` }), text);
  return el('p', { className: 'overlay-key' }, entry('seen', 'covered'), entry('wanted', 'board is wanted'), entry('outline', 'boards taken'));
}
