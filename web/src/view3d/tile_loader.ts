// SPDX-License-Identifier: Apache-2.0
// Fetches tiles, a few at a time, those that are wanted now first.
import { parsePointArrays } from '../scene/parse_layers';
import { readBlock } from '../scene/parse';
import { SceneError, type PointsLayer, type TileIndex } from '../scene/scene';

const mostAtOnce = 4;
/** A server that was away may be back when the view moves again. */
const againAfterMs = 2000;

export type TilePoints = Omit<PointsLayer, 'kind' | 'name' | 'tiles'>;

/** Nothing in the bytes may be believed: a bad tile throws SceneError and nothing else. */
export function readTile(bytes: Uint8Array, points: number, keyframes: number): TilePoints {
  const entry = readBlock(bytes, 'tile');
  if (entry.text('type') !== 'tile') throw new SceneError('the server sent no tile');
  const tile = parsePointArrays(entry, keyframes);
  if (tile.count !== points) throw new SceneError(`the tile has ${tile.count} points, not ${points}`);
  return tile;
}

export class TileLoader {
  /** From when on a tile that did not come may be asked for again (Date.now()); never, where what came cannot be read. */
  private readonly notBefore = new Map<number, number>();
  private readonly loading = new Set<number>();
  private wanted: number[] = [];

  /** `settled`: after each tile, also one that did not come. */
  constructor(
    private readonly index: TileIndex, private readonly keyframes: number,
    private readonly arrived: (row: number, tile: TilePoints) => void, private readonly settled: () => void,
  ) {}

  /** What is still missing; takes the place of what was wanted before. */
  want(rows: number[]): void {
    const now = Date.now();
    this.wanted = rows.filter((row) => !this.loading.has(row) && now >= (this.notBefore.get(row) ?? 0));
    this.fill();
  }

  /** Tiles that may still come. */
  get open(): number {
    return this.wanted.length + this.loading.size;
  }

  private fill(): void {
    while (this.loading.size < mostAtOnce && this.wanted.length > 0) void this.load(this.wanted.shift()!);
  }

  private async load(row: number): Promise<void> {
    this.loading.add(row);
    let tile: TilePoints | null = null;
    try {
      const response = await fetch(this.index.url!(row));
      if (response.ok) tile = readTile(new Uint8Array(await response.arrayBuffer()), this.index.counts[row], this.keyframes);
    } catch (error) {
      if (!(error instanceof SceneError || error instanceof TypeError)) console.error(error);
      if (error instanceof SceneError) this.notBefore.set(row, Infinity);
    }
    this.loading.delete(row);
    if (tile) this.arrived(row, tile);
    else this.notBefore.set(row, Math.max(this.notBefore.get(row) ?? 0, Date.now() + againAfterMs));
    this.fill();
    this.settled();
  }
}
