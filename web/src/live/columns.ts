// SPDX-License-Identifier: Apache-2.0
// Arrays that grow by doubling, one row a frame.

type Values = Float64Array | Float32Array | Uint8Array | Int32Array;

export class Column<T extends Values> {
  constructor(private array: T, readonly width: number) {}

  /** Writes a row, which may be the one after the last. */
  set(row: number, ...values: number[]): void {
    const end = (row + 1) * this.width;
    if (end > this.array.length) this.grow(end);
    this.array.set(values, row * this.width);
  }

  /** The first `rows` rows, not copied. */
  view(rows: number): T {
    return this.array.subarray(0, rows * this.width) as T;
  }

  private grow(needed: number): void {
    const type = this.array.constructor as new (length: number) => T;
    const larger = new type(Math.max(64 * this.width, 2 * this.array.length, needed));
    larger.set(this.array);
    this.array = larger;
  }
}

export const f64 = (width: number) => new Column(new Float64Array(0), width);
export const f32 = (width: number) => new Column(new Float32Array(0), width);
export const u8 = (width: number) => new Column(new Uint8Array(0), width);
