/** Hits and misses of beams in cells, cut into tiles. */
import type { Pose } from "../src/geometry.ts";

export interface Tiles {
  ids: number[];
  cells: Uint8Array[];
}

export class TiledMap {
  private readonly tiles = new Map<string, { hits: Uint16Array; misses: Uint16Array }>();
  private readonly changed = new Set<string>();

  constructor(
    readonly resolution: number,
    readonly size: number,
  ) {}

  private count(x: number, y: number, hit: boolean): void {
    const column = Math.floor(x / this.resolution);
    const row = Math.floor(y / this.resolution);
    const tile = `${Math.floor(column / this.size)},${Math.floor(row / this.size)}`;
    let counts = this.tiles.get(tile);
    if (counts === undefined) {
      const cells = this.size * this.size;
      counts = { hits: new Uint16Array(cells), misses: new Uint16Array(cells) };
      this.tiles.set(tile, counts);
    }
    const within = (value: number) => ((value % this.size) + this.size) % this.size;
    const at = within(row) * this.size + within(column);
    const values = hit ? counts.hits : counts.misses;
    values[at] = (values[at] ?? 0) + 1;
    this.changed.add(tile);
  }

  addScan(pose: Pose, angles: number[], ranges: number[], most: number): void {
    angles.forEach((angle, i) => {
      const range = ranges[i] ?? Infinity;
      const c = Math.cos(pose.yaw + angle);
      const s = Math.sin(pose.yaw + angle);
      const free = Math.min(range, most) - 1.5 * this.resolution;
      for (let d = 0; d < free; d += this.resolution)
        this.count(pose.x + d * c, pose.y + d * s, false);
      if (range < most) this.count(pose.x + range * c, pose.y + range * s, true);
    });
  }

  private cellsOf(key: string): Uint8Array {
    const counts = this.tiles.get(key);
    const cells = new Uint8Array(this.size * this.size).fill(255);
    if (counts === undefined) return cells;
    for (let i = 0; i < cells.length; i++) {
      const hits = 3 * (counts.hits[i] ?? 0);
      const all = hits + (counts.misses[i] ?? 0);
      if (all > 0) cells[i] = Math.round((100 * hits) / all);
    }
    return cells;
  }

  /** Of those that have changed since it was asked last, or of all. */
  take(all: boolean): Tiles {
    const keys = [...(all ? this.tiles.keys() : this.changed)];
    if (!all) this.changed.clear();
    return {
      ids: keys.flatMap((key) => key.split(",").map(Number)),
      cells: keys.map((key) => this.cellsOf(key)),
    };
  }
}
