// SPDX-License-Identifier: Apache-2.0
// Points in tiles: the root is in the scene, finer tiles are fetched where the view needs them and given back when they
// were not seen for long.
import type * as THREE from 'three';
import type { Keyframes, PointsLayer as PointsData, TileIndex } from '../scene/scene';
import { classes, geometriesOf, PointsLayer } from './points_layer';
import { childrenOf, chooseTiles, type TileView } from './tile_choice';
import { TileLoader, type TilePoints } from './tile_loader';

interface Tile {
  data: PointsData;
  points: THREE.Points;
  /** Number of the look that wanted it last. */
  used: number;
}

/** Tiles that are not seen now are kept up to this many times the points of a picture. */
const keptShare = 1.5;

export class TiledPoints extends PointsLayer {
  /** Called after each tile that was fetched. */
  onArrival: () => void = () => {};
  private readonly index: TileIndex;
  private readonly children: number[][];
  private readonly loader: TileLoader;
  /** All that are held, by row. */
  private readonly tiles = new Map<number, Tile>();
  private chosen = new Set<number>();
  /** In the picture, or in what of it comes next; the coarse ones first. */
  private drawn: Tile[] = [];
  /** Came since. */
  private fresh: Tile[] = [];
  private looks = 0;
  private held = 0;

  constructor(data: PointsData, keyframes: Keyframes | null, runColor: string) {
    super(data, keyframes, runColor);
    this.index = data.tiles!;
    this.children = childrenOf(this.index);
    this.loader = new TileLoader(this.index, keyframes?.count ?? 0, (row, tile) => this.add(row, tile), () => this.onArrival());
  }

  override get shown(): PointsData[] {
    return [this.data, ...this.drawn.map((tile) => tile.data)];
  }

  /** Tiles that the view needs and that are on their way. */
  get waiting(): number {
    return this.loader.open;
  }

  /** A picture of another view begins. */
  look(view: TileView): void {
    this.looks++;
    const rows = chooseTiles(this.index, this.children, view);
    this.chosen = new Set(rows);
    this.fresh = [];
    this.drawn = rows.flatMap((row) => this.tiles.get(row) ?? []);
    for (const tile of this.drawn) tile.used = this.looks;
    this.loader.want(rows.filter((row) => !this.tiles.has(row)));
    this.giveBack(keptShare * view.mostPoints);
  }

  override setSlice(from: number, to: number, first: boolean): void {
    super.setSlice(from, to, first);
    for (const tile of this.tiles.values()) tile.points.visible = false;
    const all = this.drawn.reduce((sum, tile) => sum + tile.data.count, 0);
    let before = 0;
    for (const tile of this.drawn) {
      const at = (before / all) * classes;
      tile.points.visible = at >= from && at < to;
      before += tile.data.count;
    }
  }

  /** What came since, to be drawn over the picture; false where nothing did. */
  showFresh(): boolean {
    const any = this.fresh.length > 0;
    for (const tile of this.fresh) tile.points.visible = true;
    this.drawn.push(...this.fresh);
    this.fresh = [];
    return any;
  }

  private add(row: number, tile: TilePoints): void {
    const data: PointsData = { kind: 'points', name: this.data.name, tiles: null, ...tile };
    const points = this.part(geometriesOf(data, this.keyframes)[0]);
    points.visible = false;
    const held = { data, points, used: this.looks };
    this.tiles.set(row, held);
    this.held += data.count;
    if (this.chosen.has(row)) this.fresh.push(held);
  }

  /** Those that were not seen for the longest time. */
  private giveBack(most: number): void {
    if (this.held <= most) return;
    const old = [...this.tiles].filter(([row]) => !this.chosen.has(row)).sort(([, a], [, b]) => a.used - b.used);
    for (const [row, tile] of old) {
      if (this.held <= most) return;
      this.object.remove(tile.points);
      tile.points.geometry.dispose();
      this.tiles.delete(row);
      this.held -= tile.data.count;
    }
  }
}
