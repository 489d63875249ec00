import assert from "node:assert/strict";
import { test } from "node:test";
import { distanceToSegment } from "../src/geometry.ts";
import { neededNodes } from "../src/simplify.ts";
import { Random } from "../demo/random.ts";

function walk(random: Random, count: number, wildness: number): { x: number; y: number }[] {
  let yaw = 0;
  let at = { x: 0, y: 0 };
  return Array.from({ length: count }, () => {
    yaw += random.normal(wildness);
    const step = random.next() < 0.1 ? 0 : random.between(0, 1);
    at = { x: at.x + step * Math.cos(yaw), y: at.y + step * Math.sin(yaw) };
    return at;
  });
}

test("no node that is left out lies far from the line", () => {
  const random = new Random(14);
  for (let trial = 0; trial < 300; trial++) {
    const points = walk(random, 1 + random.integer(200), [0, 0.02, 0.3, 3][trial % 4] ?? 0);
    const tolerance = [0.01, 0.1, 1][trial % 3] ?? 1;
    const breaks = (i: number) => i % 67 === 66;
    const x = (i: number) => points[i]?.x ?? NaN;
    const y = (i: number) => points[i]?.y ?? NaN;
    const kept = neededNodes(points.length, x, y, tolerance, 20, breaks);
    assert.equal(kept[0], 0);
    assert.equal(kept[kept.length - 1], points.length - 1);
    for (let k = 1; k < kept.length; k++) {
      const [a = 0, b = 0] = [kept[k - 1], kept[k]];
      assert.ok(b > a);
      for (let i = a + 1; i < b; i++) {
        assert.ok(!breaks(i) || breaks(b) || i === b, "breaks are kept");
        const [p, from, to] = [points[i], points[a], points[b]];
        assert.ok(p && from && to);
        const apart = distanceToSegment(p, from, to);
        assert.ok(apart <= 2 * tolerance + 1e-9, `${apart} at ${i} of trial ${trial}`);
      }
    }
    for (let i = 1; i < points.length; i++)
      if (breaks(i)) assert.ok(kept.includes(i) && kept.includes(i - 1));
  }
});

test("a straight line needs few nodes, but some, for its colours", () => {
  const kept = neededNodes(
    1000,
    (i) => i,
    () => 0,
    0.1,
    100,
    () => false,
  );
  assert.ok(kept.length >= 10 && kept.length <= 13, String(kept.length));
  assert.deepEqual(
    neededNodes(
      0,
      () => 0,
      () => 0,
      1,
      1,
      () => false,
    ),
    [],
  );
  assert.deepEqual(
    neededNodes(
      1,
      () => 0,
      () => 0,
      1,
      1,
      () => false,
    ),
    [0],
  );
});
