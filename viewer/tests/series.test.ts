import assert from "node:assert/strict";
import { test } from "node:test";
import { Series } from "../src/series.ts";
import { Track } from "../src/track.ts";
import { Random } from "../demo/random.ts";

const rangeOf = (series: Series) => {
  const used = <T extends Float32Array>(values: T) => [...values.subarray(0, series.length)];
  return [Math.min(...used(series.low)), Math.max(...used(series.high))];
};

test("however many values come, room stays the same and no peak is lost", () => {
  const random = new Random(6);
  const series = new Series(64);
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < 100_000; i++) {
    const value = Math.fround(random.normal(1) + (i === 54_321 ? 99 : 0));
    low = Math.min(low, value);
    high = Math.max(high, value);
    series.add(i, value);
    assert.ok(series.length <= 64);
    if (i % 997 === 0) assert.deepEqual(rangeOf(series), [low, high]);
  }
  assert.deepEqual(rangeOf(series), [low, high]);
  assert.ok(series.length >= 32);
  const spike = series.nearest(54_321);
  assert.equal(series.high[spike], high);
  for (let i = 1; i < series.length; i++) {
    assert.ok(
      (series.begin[i] ?? 0) > (series.end[i - 1] ?? 0),
      "buckets in order, without overlap",
    );
  }
  assert.equal(series.begin[0], 0);
  assert.equal(series.end[series.length - 1], 99_999);
});

test("time that goes back takes with it what came later", () => {
  const series = new Series(8);
  for (let t = 0; t < 100; t++) series.add(t, t);
  series.add(40, -1);
  assert.equal(series.end[series.length - 1], 40);
  assert.equal(series.last[series.length - 1], -1);
  series.add(-5, 3);
  assert.equal(series.length, 1);
  assert.deepEqual(rangeOf(series), [3, 3]);
});

test("what is no number is left out", () => {
  const series = new Series();
  series.add(NaN, 1);
  series.add(1, NaN);
  series.add(1, Infinity);
  assert.equal(series.length, 0);
  assert.equal(series.nearest(1), -1);
});

test("the nearest bucket is the one that a search through all finds", () => {
  const random = new Random(8);
  const series = new Series(32);
  let t = 0;
  for (let i = 0; i < 300; i++) series.add((t += random.between(0.1, 3)), i);
  for (let i = 0; i < 500; i++) {
    const at = random.between(-5, t + 5);
    let least = Infinity;
    for (let k = 0; k < series.length; k++) {
      least = Math.min(least, Math.max((series.begin[k] ?? 0) - at, at - (series.end[k] ?? 0), 0));
    }
    const found = series.nearest(at);
    const apart = Math.max((series.begin[found] ?? 0) - at, at - (series.end[found] ?? 0), 0);
    assert.ok(Math.abs(apart - least) < 1e-9);
  }
});

test("a path grows, is replaced from a node on, and shrinks", () => {
  const track = new Track();
  const given = (first: number, count: number, shift = 0) => {
    const n = count - first;
    const t = Float64Array.from({ length: n }, (_, i) => first + i);
    const poses = Float32Array.from({ length: 3 * n }, (_, i) =>
      i % 3 === 0 ? first + i / 3 + shift : 0,
    );
    const zeros = new Uint32Array(n);
    return { first, count, t, poses, sigma: new Float32Array(n), submaps: zeros, drives: zeros };
  };
  assert.equal(track.replace(given(1, 3)), false);
  assert.ok(track.replace(given(0, 5000)));
  assert.ok(track.replace(given(4000, 4500, 0.5)));
  assert.equal(track.length, 4500);
  assert.equal(track.x(3999), 3999);
  assert.equal(track.x(4000), 4000.5);
  assert.equal(track.pose(4500), null);
  assert.equal(track.neighbour(10, 1), 11);
  assert.equal(track.neighbour(10.5, -1), 10);
  assert.equal(track.neighbour(0, -1), null);
});
