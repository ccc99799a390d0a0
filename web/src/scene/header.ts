// SPDX-License-Identifier: Apache-2.0
// Checked access to the header (JSON from outside: nothing in it may be believed) and to the arrays it refers to.
import { SceneError, type Vec3 } from './scene';

type Json = Record<string, unknown>;

const types = {
  f32: Float32Array,
  f64: Float64Array,
  u8: Uint8Array,
  u32: Uint32Array,
  i32: Int32Array,
} as const;

type ArrayType = keyof typeof types;
type ArrayOf<T extends ArrayType> = InstanceType<(typeof types)[T]>;

/** One object of the header. `where` names it in messages. */
export class Entry {
  constructor(
    private readonly json: Json,
    private readonly body: Uint8Array<ArrayBuffer>,
    readonly where: string,
  ) {}

  static from(value: unknown, body: Uint8Array<ArrayBuffer>, where: string): Entry {
    if (typeof value !== 'object' || value === null || Array.isArray(value)) {
      throw new SceneError(`${where} is not an object`);
    }
    return new Entry(value as Json, body, where);
  }

  has(key: string): boolean {
    return Object.hasOwn(this.json, key) && this.json[key] !== null;
  }

  value(key: string): unknown {
    return Object.hasOwn(this.json, key) ? this.json[key] : undefined;
  }

  child(key: string): Entry | null {
    return this.has(key) ? Entry.from(this.json[key], this.body, this.name(key)) : null;
  }

  children(key: string): Entry[] {
    if (!this.has(key)) return [];
    const list = this.json[key];
    if (!Array.isArray(list)) throw this.error(key, 'is not a list');
    return list.map((value, i) => Entry.from(value, this.body, `${this.name(key)}[${i}]`));
  }

  text(key: string, missing?: string): string {
    if (!this.has(key) && missing !== undefined) return missing;
    const value = this.value(key);
    if (typeof value !== 'string') throw this.error(key, 'is not a text');
    return value.slice(0, 1000);
  }

  flag(key: string): boolean {
    const value = this.value(key) ?? false;
    if (typeof value !== 'boolean') throw this.error(key, 'is not true or false');
    return value;
  }

  number(key: string): number {
    const value = this.value(key);
    if (typeof value !== 'number' || !Number.isFinite(value)) throw this.error(key, 'is not a number');
    return value;
  }

  numberOrNull(key: string): number | null {
    return this.has(key) ? this.number(key) : null;
  }

  /** A whole number in [0, end). */
  index(key: string, end: number): number {
    const value = this.number(key);
    if (!Number.isInteger(value) || value < 0 || value >= end) {
      throw this.error(key, end > 0 ? `is ${value}, not a whole number from 0 to ${end - 1}` : 'refers to what is not there');
    }
    return value;
  }

  positive(key: string): number {
    const value = this.number(key);
    if (value <= 0) throw this.error(key, `is ${value}, not above 0`);
    return value;
  }

  numbers(key: string, count: number): number[] {
    const value = this.value(key);
    const good = Array.isArray(value) && value.length === count && value.every((v) => Number.isFinite(v));
    if (!good) throw this.error(key, `is not a list of ${count} numbers`);
    return value as number[];
  }

  vec3(key: string): Vec3 {
    return this.numbers(key, 3) as Vec3;
  }

  /** The array that `key` refers to, with `columns` numbers a row; `rows` fixes the number of rows where it is known. */
  array<T extends ArrayType>(key: string, type: T, columns: number, rows: number | null): ArrayOf<T> {
    const ref = this.child(key);
    if (!ref) throw this.error(key, 'is missing');
    if (ref.text('type') !== type) throw this.error(key, `has type ${ref.text('type')}, not ${type}`);
    const offset = ref.index('offset', 2 ** 48);
    const count = ref.index('count', 2 ** 48);
    if (offset % 8 !== 0) throw this.error(key, `starts at ${offset}, not a multiple of 8`);
    if (offset + count * types[type].BYTES_PER_ELEMENT > this.body.length) {
      throw this.error(key, 'reaches past the end of the scene; the file may be cut off');
    }
    if (count % columns !== 0) throw this.error(key, `has ${count} numbers, not a multiple of ${columns}`);
    if (rows !== null && count !== rows * columns) {
      throw this.error(key, `has ${count / columns} rows where ${rows} are needed`);
    }
    return new types[type](this.body.buffer, this.body.byteOffset + offset, count) as ArrayOf<T>;
  }

  arrayOrNull<T extends ArrayType>(key: string, type: T, columns: number, rows: number | null): ArrayOf<T> | null {
    return this.has(key) ? this.array(key, type, columns, rows) : null;
  }

  error(key: string, what: string): SceneError {
    return new SceneError(`${this.name(key)} ${what}`);
  }

  private name(key: string): string {
    return this.where === '' ? key : `${this.where}.${key}`;
  }
}

/** Every value below `end`; a mesh or an edge with an index past the end would draw garbage. */
export function checkIndices(values: ArrayLike<number>, end: number, where: string): void {
  for (let i = 0; i < values.length; i++) {
    if (values[i] >= end) throw new SceneError(`${where} has the index ${values[i]}, but there are only ${end} rows`);
  }
}
