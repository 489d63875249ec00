import assert from "node:assert/strict";
import { test } from "node:test";
import { Camera } from "../src/camera.ts";
import * as geometry from "../src/geometry.ts";
import { Measure } from "../src/measure.ts";
import { gridStep } from "../src/scene.ts";
import { Random } from "../demo/random.ts";

const near = (a: number, b: number, within = 1e-9) =>
  assert.ok(Math.abs(a - b) <= within, `${a} is not ${b}`);

function poses(count: number): geometry.Pose[] {
  const random = new Random(4);
  const made = Array.from({ length: count }, () => ({
    x: random.between(-50, 50),
    y: random.between(-50, 50),
    yaw: random.between(-Math.PI, Math.PI),
  }));
  return [geometry.kIdentity, { x: 1e-9, y: 0, yaw: -1e-9 }, { x: 0, y: 0, yaw: Math.PI }, ...made];
}

test("a pose times its inverse is nothing, and poses act one after the other", () => {
  for (const a of poses(100)) {
    const none = geometry.compose(a, geometry.inverse(a));
    near(none.x, 0);
    near(none.y, 0);
    near(Math.sin(none.yaw), 0);
    for (const b of poses(5)) {
      const p = { x: 1, y: -2 };
      const once = geometry.apply(geometry.compose(a, b), p);
      const twice = geometry.apply(a, geometry.apply(b, p));
      near(once.x, twice.x);
      near(once.y, twice.y);
    }
  }
});

test("angles are wrapped into (-pi, pi]", () => {
  near(geometry.wrapAngle(3 * Math.PI), Math.PI);
  near(geometry.wrapAngle(-Math.PI), Math.PI);
  near(geometry.wrapAngle(0.5 - 8 * Math.PI), 0.5);
});

test("bearings count from x, counter-clockwise", () => {
  const o = { x: 1, y: 1 };
  near(geometry.bearing(o, { x: 2, y: 1 }), 0);
  near(geometry.bearing(o, { x: 1, y: 2 }), 90);
  near(geometry.bearing(o, { x: 0, y: 1 }), 180);
  near(geometry.bearing(o, { x: 1, y: 0 }), 270);
});

test("the ellipse of a covariance", () => {
  const turned = geometry.ellipseOf(2.5, 1.5, 2.5);
  near(turned.major, 2);
  near(turned.minor, 1);
  near(turned.angle, Math.PI / 4);
  const flat = geometry.ellipseOf(1, 1.0001, 1);
  near(flat.minor, 0);
});

test("distance to a line is that of the nearest of many points on it", () => {
  const random = new Random(9);
  for (let i = 0; i < 200; i++) {
    const p = () => ({ x: random.between(-3, 3), y: random.between(-3, 3) });
    const [at, a, b] = [p(), p(), p()];
    let least = Infinity;
    for (let k = 0; k <= 2000; k++) {
      const s = k / 2000;
      least = Math.min(
        least,
        Math.hypot(a.x + s * (b.x - a.x) - at.x, a.y + s * (b.y - a.y) - at.y),
      );
    }
    near(geometry.distanceToSegment(at, a, b), least, 3e-3);
  }
  near(geometry.distanceToSegment({ x: 3, y: 4 }, { x: 0, y: 0 }, { x: 0, y: 0 }), 5);
});

test("round lengths", () => {
  for (const [length, round] of [
    [1, 1],
    [1.9, 1],
    [2, 2],
    [7, 5],
    [0.03, 0.02],
    [999, 500],
    [1000, 1000],
    [0, 1],
    [NaN, 1],
  ] as const) {
    near(geometry.roundLength(length), round, 1e-12);
  }
});

test("lines of the grid are never closer than 60 pixels, nor much farther apart", () => {
  for (let scale = 0.02; scale < 4000; scale *= 1.07) {
    const pixels = gridStep(scale) * scale;
    assert.ok(pixels > 59.9 && pixels < 151, `${pixels} at ${scale}`);
  }
});

test("the camera: there and back again, and what is zoomed at stays", () => {
  const random = new Random(5);
  const camera = new Camera();
  camera.width = 800;
  camera.height = 500;
  for (let i = 0; i < 300; i++) {
    const at = { x: random.between(0, 800), y: random.between(0, 500) };
    const before = camera.toWorld(at);
    camera.zoomAt(at, random.between(0.5, 2), random.between(-1, 1));
    const back = camera.toScreen(before);
    near(back.x, at.x, 1e-6);
    near(back.y, at.y, 1e-6);
    camera.pan(random.between(-30, 30), random.between(-30, 30));
    const there = camera.toWorld(camera.toScreen({ x: 3, y: 4 }));
    near(there.x, 3, 1e-6);
    near(there.y, 4, 1e-6);
  }
});

test("panning moves the map with the pointer", () => {
  const camera = new Camera();
  Object.assign(camera, { width: 400, height: 400, angle: 0.7, scale: 13 });
  const before = camera.toScreen({ x: 2, y: 1 });
  camera.pan(10, -25);
  const after = camera.toScreen({ x: 2, y: 1 });
  near(after.x - before.x, 10);
  near(after.y - before.y, -25);
});

test("fitting shows all of a box, beside the tools, at any turn", () => {
  const camera = new Camera();
  Object.assign(camera, { width: 900, height: 400 });
  const box = { left: -3, bottom: 2, right: 30, top: 12 };
  for (let angle = -3; angle < 3; angle += 0.37) {
    camera.angle = angle;
    Object.assign(camera, camera.fitting(box, 44, 120));
    for (const x of [box.left, box.right]) {
      for (const y of [box.bottom, box.top]) {
        const p = camera.toScreen({ x, y });
        assert.ok(p.x > 44 && p.x < 900 && p.y > 0 && p.y < 280, JSON.stringify(p));
      }
    }
  }
});

test("measuring: lengths, direction, taking back, a new line after the end", () => {
  const measure = new Measure();
  assert.equal(measure.lastBearing, null);
  measure.add({ x: 0, y: 0 });
  measure.add({ x: 3, y: 4 });
  measure.add({ x: 3, y: 9 });
  near(measure.total, 10);
  near(measure.segment(1), 5);
  near(measure.lastBearing ?? NaN, 90);
  measure.undo();
  near(measure.total, 5);
  measure.finish();
  measure.add({ x: 1, y: 1 });
  assert.equal(measure.points.length, 1);
});
