// SPDX-License-Identifier: Apache-2.0
// An image of the run on a canvas as wide as its place in the page, with its features drawn over it.
import { el } from '../ui/dom';
import { drawShapes, featureStyle } from './feature_style';
import { drawIds, drawTrails } from './feature_tracks';
import type { LiveImage } from './messages';

/** Pixels of the page. */
const farthestHover = 12;

export class FeatureImage {
  readonly canvas = el('canvas', { role: 'img', aria: { label: 'Image of the frame with its features' } });
  private image: LiveImage | null = null;
  private picture: ImageBitmap | null = null;
  private wanted: LiveImage | null = null;
  private decoding = false;
  /** The feature under the pointer, -1 without one. */
  private hovered = -1;

  /** Drawn over the image, below its features; `scale` is pixels of the page per pixel of the image. */
  underFeatures: (context: CanvasRenderingContext2D, image: LiveImage, scale: number) => void = () => {};
  /** Called after an image is drawn. */
  onDrawn: (image: LiveImage) => void = () => {};

  /** `hidden`: states that are not drawn. */
  constructor(readonly hidden = new Set<string>()) {
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    this.canvas.addEventListener('pointermove', (event) => this.hover(event.offsetX, event.offsetY));
    this.canvas.addEventListener('pointerleave', () => this.hover(NaN, NaN));
  }

  /** Images come faster than a slow computer decodes them: the newest counts. */
  show(image: LiveImage | null): void {
    if (image === this.wanted) return;
    this.wanted = image;
    if (!this.decoding) void this.decode();
  }

  draw(): void {
    const { canvas, image, picture } = this;
    const width = canvas.clientWidth;
    if (!image || width === 0) return;
    const ratio = Math.min(2, devicePixelRatio);
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round((canvas.width * image.height) / image.width);
    const context = canvas.getContext('2d')!;
    if (picture) context.drawImage(picture, 0, 0, canvas.width, canvas.height);
    context.scale(ratio, ratio);
    this.underFeatures(context, image, width / image.width);
    this.drawFeatures(context, width / image.width, Math.max(2.5, Math.min(4, width / 100)));
  }

  private drawFeatures(context: CanvasRenderingContext2D, scale: number, radius: number): void {
    const { features, states, stateNames, colors } = this.image!;
    if (colors) return drawColored(context, this.image!, scale);
    drawTrails(context, this.image!, this.hidden, scale);
    const points: number[][] = stateNames.map(() => []);
    states.forEach((state, i) => {
      // A state without a name, or a place that is none, is passed over.
      const [x, y] = [features[2 * i] * scale, features[2 * i + 1] * scale];
      if (state < points.length && Number.isFinite(x) && Number.isFinite(y)) points[state].push(x, y);
    });
    stateNames.forEach((name, i) => {
      if (!this.hidden.has(name)) drawShapes(context, featureStyle(name, i), points[i], radius);
    });
    drawIds(context, this.image!, this.hidden, scale, this.hovered);
  }

  /** Pixels of the page. */
  private hover(x: number, y: number): void {
    const hovered = this.image?.ids ? this.nearest(x, y) : -1;
    if (hovered === this.hovered) return;
    this.hovered = hovered;
    this.draw();
  }

  private nearest(x: number, y: number): number {
    const { features, width } = this.image!;
    const scale = this.canvas.clientWidth / width;
    let [best, nearest] = [-1, farthestHover];
    for (let i = 0; 2 * i < features.length; i++) {
      const distance = Math.hypot(features[2 * i] * scale - x, features[2 * i + 1] * scale - y);
      if (distance < nearest) [best, nearest] = [i, distance];
    }
    return best;
  }

  private async decode(): Promise<void> {
    this.decoding = true;
    while (this.wanted !== this.image) {
      const image = this.wanted;
      const picture = image && (await decoded(image.jpeg));
      this.picture?.close();
      [this.image, this.picture] = [image, picture];
      this.hovered = -1;
      if (!image) {
        // The next one must not begin as the last one.
        this.canvas.getContext('2d')!.clearRect(0, 0, this.canvas.width, this.canvas.height);
        continue;
      }
      this.canvas.style.aspectRatio = `${image.width} / ${image.height}`;
      this.canvas.style.setProperty('--ratio', `${image.width / image.height}`);
      this.draw();
      this.onDrawn(image);
    }
    this.decoding = false;
  }
}

/** Small squares in colors of their own. */
function drawColored(context: CanvasRenderingContext2D, { features, colors }: LiveImage, scale: number): void {
  const side = Math.max(3, 2 * scale);
  for (let i = 0; 2 * i < features.length; i++) {
    context.fillStyle = `rgb(${colors![3 * i]}, ${colors![3 * i + 1]}, ${colors![3 * i + 2]})`;
    context.fillRect(features[2 * i] * scale - side / 2, features[2 * i + 1] * scale - side / 2, side, side);
  }
}

/** Null for bytes that are no image: the features are shown without it. */
async function decoded(jpeg: Uint8Array): Promise<ImageBitmap | null> {
  try {
    return await createImageBitmap(new Blob([jpeg as BlobPart], { type: 'image/jpeg' }));
  } catch {
    return null;
  }
}
