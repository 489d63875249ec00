import assert from "node:assert/strict";
import { test } from "node:test";
import { blockOf, extentOf, halved, halvings, stored } from "../src/gl/cells.ts";
import { Random } from "../demo/random.ts";

test("unknown is 0, occupancy one more than it was", () => {
  const out = new Uint8Array(5);
  stored(Uint8Array.of(255, 0, 100, 101, 50), out);
  assert.deepEqual([...out], [0, 1, 101, 101, 51]);
});

test("half the size holds the largest of each four", () => {
  const random = new Random(2);
  const side = 16;
  const from = Uint8Array.from({ length: side * side }, () => random.integer(102));
  const out = new Uint8Array(64);
  halved(from, side, out);
  for (let row = 0; row < 8; row++) {
    for (let column = 0; column < 8; column++) {
      const at = (dx: number, dy: number) => from[(2 * row + dy) * side + 2 * column + dx] ?? 0;
      assert.equal(out[row * 8 + column], Math.max(at(0, 0), at(1, 0), at(0, 1), at(1, 1)));
    }
  }
});

test("sides are halved while they are even", () => {
  assert.deepEqual([1, 2, 64, 100, 256, 75].map(halvings), [0, 1, 6, 2, 8, 0]);
});

test("tiles find their block, on either side of nought", () => {
  for (let tile = -20; tile < 20; tile++) {
    const { block, within } = blockOf(tile, 8);
    assert.equal(block * 8 + within, tile);
    assert.ok(within >= 0 && within < 8);
  }
});

test("the extent of what is known", () => {
  const cells = new Uint8Array(16);
  assert.equal(extentOf(cells, 4), null);
  cells[6] = 1;
  cells[9] = 5;
  assert.deepEqual(extentOf(cells, 4), { left: 1, bottom: 1, right: 3, top: 3 });
});
