// SPDX-License-Identifier: Apache-2.0
// Images of the newest frames, for scrubbing back.
import type { LiveImage } from './messages';

const mostBytes = 48e6;
/** An image of a frame that is farther away would mislead. */
const farthest = 40;

export class ImageStore {
  private images: LiveImage[] = [];
  private bytes = 0;

  get last(): LiveImage | null {
    return this.images[this.images.length - 1] ?? null;
  }

  /** False for an image that comes too late. */
  add(image: LiveImage): boolean {
    if (this.last && image.index <= this.last.index) return false;
    this.images.push(image);
    this.bytes += sizeOf(image);
    while (this.bytes > mostBytes && this.images.length > 1) this.bytes -= sizeOf(this.images.shift()!);
    return true;
  }

  clear(): void {
    this.images = [];
    this.bytes = 0;
  }

  /** The image of a frame, else that of the frame nearest before it, else the nearest after it. */
  near(index: number): LiveImage | null {
    const before = this.images.findLast((image) => image.index <= index);
    const image = before ?? this.images[0] ?? null;
    return image && Math.abs(image.index - index) <= farthest ? image : null;
  }
}

/** Arrays of one message share its bytes. */
function sizeOf(image: LiveImage): number {
  return image.jpeg.buffer.byteLength;
}
