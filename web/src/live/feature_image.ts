// SPDX-License-Identifier: Apache-2.0
// An image of the run on a canvas as wide as its place in the page, with its features drawn over it.
import { el } from '../ui/dom';
import { drawShapes, featureStyle } from './feature_style';
import type { LiveImage } from './messages';

export class FeatureImage {
  readonly canvas = el('canvas', { role: 'img', aria: { label: 'Image of the frame with its features' } });
  /** States that are not drawn. */
  readonly hidden = new Set<string>();
  private image: LiveImage | null = null;
  private picture: ImageBitmap | null = null;
  private wanted: LiveImage | null = null;
  private decoding = false;

  /** Called after an image is drawn. */
  onDrawn: (image: LiveImage) => void = () => {};

  constructor() {
    new ResizeObserver(() => this.draw()).observe(this.canvas);
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
    this.drawFeatures(context, width / image.width, Math.max(2.5, Math.min(4, width / 100)));
  }

  private drawFeatures(context: CanvasRenderingContext2D, scale: number, radius: number): void {
    const { features, states, stateNames } = this.image!;
    const points: number[][] = stateNames.map(() => []);
    states.forEach((state, i) => {
      // A state without a name, or a place that is none, is passed over.
      const [x, y] = [features[2 * i] * scale, features[2 * i + 1] * scale];
      if (state < points.length && Number.isFinite(x) && Number.isFinite(y)) points[state].push(x, y);
    });
    stateNames.forEach((name, i) => {
      if (!this.hidden.has(name)) drawShapes(context, featureStyle(name, i), points[i], radius);
    });
  }

  private async decode(): Promise<void> {
    this.decoding = true;
    while (this.wanted !== this.image) {
      const image = this.wanted;
      const picture = image && (await decoded(image.jpeg));
      this.picture?.close();
      [this.image, this.picture] = [image, picture];
      if (!image) continue;
      this.canvas.style.aspectRatio = `${image.width} / ${image.height}`;
      this.draw();
      this.onDrawn(image);
    }
    this.decoding = false;
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
