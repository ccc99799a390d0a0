// SPDX-License-Identifier: Apache-2.0
// Fetches tiles, a few at a time, those that are wanted now first.
import { parsePointArrays } from '../scene/parse_layers';
import { readBlock } from '../scene/parse';
import { SceneError, type PointsLayer, type TileIndex } from '../scene/scene';

const mostAtOnce = 4;

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
  /** Not asked for again: the server has gone, or what it sends cannot be read. */
  private readonly failed = new Set<number>();
  private readonly loading = new Set<number>();
  private wanted: number[] = [];

  /** `settled`: after each tile, also one that did not come. */
  constructor(
    private readonly index: TileIndex, private readonly keyframes: number,
    private readonly arrived: (row: number, tile: TilePoints) => void, private readonly settled: () => void,
  ) {}

  /** What is still missing; takes the place of what was wanted before. */
  want(rows: number[]): void {
    this.wanted = rows.filter((row) => !this.failed.has(row) && !this.loading.has(row));
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
    }
    this.loading.delete(row);
    if (tile) this.arrived(row, tile);
    else this.failed.add(row);
    this.fill();
    this.settled();
  }
}
