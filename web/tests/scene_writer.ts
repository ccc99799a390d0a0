// SPDX-License-Identifier: Apache-2.0
// Writes scenes byte by byte as the format says; independent of the page's reader.

type Values = ArrayLike<number>;
export type Ref = { offset: number; type: string; count: number };

const types = { f32: Float32Array, f64: Float64Array, u8: Uint8Array, u32: Uint32Array, i32: Int32Array } as const;

export class SceneWriter {
  private readonly parts: { offset: number; bytes: Uint8Array }[] = [];
  private size = 0;

  array(type: keyof typeof types, values: Values): Ref {
    const array = values instanceof types[type] ? values : types[type].from(values as number[]);
    const bytes = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
    const offset = this.size;
    this.parts.push({ offset, bytes });
    this.size = Math.ceil((offset + bytes.length) / 8) * 8;
    return { offset, type, count: array.length };
  }

  f32 = (values: Values) => this.array('f32', values);
  f64 = (values: Values) => this.array('f64', values);
  u8 = (values: Values) => this.array('u8', values);
  u32 = (values: Values) => this.array('u32', values);
  i32 = (values: Values) => this.array('i32', values);

  finish(header: object): Uint8Array {
    let json = new TextEncoder().encode(JSON.stringify({ format: 'rastro-scene', version: 1, ...header }));
    const length = Math.ceil((json.length + 4) / 8) * 8 - 4;
    const bytes = new Uint8Array(4 + length + this.size).fill(32, 4, 4 + length);
    new DataView(bytes.buffer).setUint32(0, length, true);
    bytes.set(json, 4);
    for (const part of this.parts) bytes.set(part.bytes, 4 + length + part.offset);
    return bytes;
  }
}

/** Random numbers that repeat (mulberry32). */
export function random(seed: number): () => number {
  let a = seed;
  return () => {
    a = (a + 0x6d2b79f5) | 0;
    let t = Math.imul(a ^ (a >>> 15), 1 | a);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}
