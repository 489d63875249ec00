import assert from "node:assert/strict";
import { test } from "node:test";
import { CdrWriter } from "../demo/cdr_writer.ts";
import * as wire from "../demo/messages.ts";
import { readLaserScan, readTransforms } from "../src/messages.ts";
import { Model } from "../src/model.ts";
import { readStatus } from "../src/json_messages.ts";

const transforms = (t: number, parent: string, child: string, x: number, yaw: number) =>
  readTransforms(wire.transforms(t, [[parent, child, { x, y: 0, yaw }]]));

/** Straight ahead is the middle one of the beams. */
function ahead(range: number): number[] {
  const ranges = new Array<number>(181).fill(Infinity);
  ranges[90] = range;
  return ranges;
}

function pointOf(model: Model): { x: number; y: number } {
  assert.equal(model.scanPoints, 1);
  const points = model.scans.get("/scan")?.points;
  return { x: points?.[0] ?? NaN, y: points?.[1] ?? NaN };
}

test("a scan lies where its laser was at its time, whichever of both comes first", () => {
  for (const scanFirst of [true, false]) {
    const model = new Model();
    model.addTransforms(transforms(0, "base_link", "laser", 0.5, 0), true);
    model.addTransforms(transforms(1, "map", "base_link", 10, 0), false);
    const pose = transforms(2, "map", "base_link", 20, Math.PI / 2);
    const scan = readLaserScan(wire.laserScan(2, ahead(3)));
    if (scanFirst) model.setScan("/scan", scan);
    model.addTransforms(pose, false);
    if (!scanFirst) model.setScan("/scan", scan);
    model.addTransforms(transforms(3, "map", "base_link", 99, 0), false);
    const { x, y } = pointOf(model);
    assert.ok(Math.abs(x - 20) < 1e-5 && Math.abs(y - 3.5) < 1e-5, `${x} ${y}`);
  }
});

test("ranges without return, too short or too long are no points", () => {
  const model = new Model();
  const ranges = new Array<number>(181).fill(Infinity);
  ranges.splice(0, 5, NaN, 0.01, 500, -1, -Infinity);
  model.setScan("/scan", readLaserScan(wire.laserScan(1, ranges)));
  assert.equal(model.scanPoints, 0);
});

test("figures become series by name, within bounds", () => {
  const model = new Model();
  for (let i = 0; i < 3; i++) {
    const figures = Object.fromEntries(Array.from({ length: 100 }, (_, k) => [`f${i}_${k}`, k]));
    const status = readStatus(JSON.stringify({ t: i, status: "tracked", figures, realtime: 2 }));
    assert.ok(status);
    model.setStatus(status);
  }
  assert.ok(model.series.size <= 64);
  assert.ok(model.series.has("f0_1"));
});

test("another run forgets all", () => {
  const model = new Model();
  model.setScan("/scan", readLaserScan(wire.laserScan(1, ahead(3))));
  model.setRobot({ x: 1, y: 1, yaw: 0 }, [1, 0, 1], 0.1);
  model.note("something");
  model.reset();
  assert.equal(model.scanPoints, 0);
  assert.equal(model.robot, null);
  assert.deepEqual(model.notes, []);
});

test("a laser that hangs upside down sees left what stands right", () => {
  const model = new Model();
  const [mount] = transforms(0, "base_link", "laser", 0, 0);
  assert.ok(mount && !mount.upsideDown);
  model.addTransforms([{ ...mount, upsideDown: true }], true);
  const ranges = new Array<number>(181).fill(Infinity);
  ranges[180] = 2; // 90 degrees to the left of the laser
  model.setScan("/scan", readLaserScan(wire.laserScan(0, ranges)));
  const { x, y } = pointOf(model);
  assert.ok(Math.abs(x) < 1e-5 && Math.abs(y + 2) < 1e-5, `${x} ${y}`);
  const turned = new CdrWriter().u32(1).header(0, "base_link").string("laser");
  const [roll] = readTransforms(turned.f64(0, 0, 0, 1, 0, 0, 0).done());
  assert.ok(roll?.upsideDown);
});

test("several lasers, each with its mount", () => {
  const model = new Model();
  model.addTransforms(transforms(0, "base_link", "laser", 1, 0), true);
  model.setScan("/scan", readLaserScan(wire.laserScan(0, ahead(3))));
  model.setScan("/scan_2", readLaserScan(wire.laserScan(0, ahead(4))));
  assert.equal(model.scanPoints, 2);
  for (let i = 3; i < 30; i++)
    model.setScan(`/scan_${i}`, readLaserScan(wire.laserScan(0, ahead(4))));
  assert.equal(model.scans.size, 8);
});
