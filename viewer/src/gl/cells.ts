/** Cells of tiles as the texture holds them, at every size that is needed. No WebGL here. */
import { type Box, emptyBox, include, isEmpty } from "../geometry.ts";

/** Occupancy 0..100 or 255 for unknown -> 1..101 or 0. Values that are neither count as 100. */
export function stored(cells: Uint8Array, out: Uint8Array): void {
  for (let i = 0; i < cells.length; i++) {
    const value = cells[i] ?? 255;
    out[i] = value === 255 ? 0 : value > 100 ? 101 : value + 1;
  }
}

/** Half the size: of four cells the most occupied, so that thin walls never vanish. */
export function halved(from: Uint8Array, side: number, out: Uint8Array): void {
  const half = side >> 1;
  for (let row = 0; row < half; row++) {
    let at = 2 * row * side;
    for (let column = 0; column < half; column++, at += 2) {
      const a = from[at] ?? 0;
      const b = from[at + 1] ?? 0;
      const c = from[at + side] ?? 0;
      const d = from[at + side + 1] ?? 0;
      const ab = a > b ? a : b;
      const cd = c > d ? c : d;
      out[row * half + column] = ab > cd ? ab : cd;
    }
  }
}

/** How often a side can be halved without a remainder. */
export function halvings(side: number): number {
  let count = 0;
  while (side > 1 && side % 2 === 0) {
    side /= 2;
    count++;
  }
  return count;
}

/** Column and row of the block that holds a tile, and the tile's place in it. */
export function blockOf(tile: number, tilesABlock: number): { block: number; within: number } {
  const block = Math.floor(tile / tilesABlock);
  return { block, within: tile - block * tilesABlock };
}

/** Columns and rows that hold what is known, the last ones not included; null without any. */
export function extentOf(cells: Uint8Array, side: number): Box | null {
  const box = emptyBox();
  for (let i = 0; i < side * side; i++) {
    if (cells[i] === 0) continue;
    const row = Math.floor(i / side);
    const column = i - row * side;
    include(box, column, row);
    include(box, column + 1, row + 1);
  }
  return isEmpty(box) ? null : box;
}
