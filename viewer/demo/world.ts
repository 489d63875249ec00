/** A small office made by code: walls as segments, beams cast on them. */
import type { Point, Pose } from "../src/geometry.ts";
import { Random } from "./random.ts";

export interface Segment {
  a: Point;
  b: Point;
}

const kWidth = 42;
const kHeight = 24;
const kRoom = 7;
const kDoor = 1.2;
const kCorridor = [10.8, 13.2] as const;

function box(x: number, y: number, w: number, h: number): Segment[] {
  const corners = [
    { x, y },
    { x: x + w, y },
    { x: x + w, y: y + h },
    { x, y: y + h },
  ];
  return corners.map((a, i) => ({ a, b: corners[(i + 1) % 4] as Point }));
}

/** Rooms on both sides of a corridor, a door each, some furniture. */
export function office(): Segment[] {
  const random = new Random(7);
  const walls = box(0, 0, kWidth, kHeight);
  for (const side of [0, 1] as const) {
    const y = kCorridor[side];
    for (let x = 0; x < kWidth; x += kRoom) {
      const door = x + kRoom / 2;
      walls.push({ a: { x, y }, b: { x: door - kDoor / 2, y } });
      walls.push({ a: { x: door + kDoor / 2, y }, b: { x: x + kRoom, y } });
      if (x > 0) walls.push({ a: { x, y }, b: { x, y: side === 0 ? 0 : kHeight } });
      const deep = side === 0 ? random.between(1.2, 3) : kHeight - random.between(2.4, 4);
      walls.push(...box(x + 0.8, deep, 1.6, 0.8));
      walls.push(...box(x + kRoom - 1.5, deep + random.between(-0.6, 0.6), 0.5, 1.2));
    }
  }
  return walls;
}

/** Range along a direction, or infinity. */
export function cast(walls: Segment[], from: Point, angle: number, most: number): number {
  const dx = Math.cos(angle);
  const dy = Math.sin(angle);
  let nearest = most;
  for (const { a, b } of walls) {
    const ex = b.x - a.x;
    const ey = b.y - a.y;
    const cross = dx * ey - dy * ex;
    if (cross === 0) continue;
    const fx = a.x - from.x;
    const fy = a.y - from.y;
    const t = (fx * ey - fy * ex) / cross;
    const u = (fx * dy - fy * dx) / cross;
    if (t > 0 && t < nearest && u >= 0 && u <= 1) nearest = t;
  }
  return nearest < most ? nearest : Infinity;
}

/** Into each room, around in it and out, there along one side and back along the other. */
export function route(): Point[] {
  const random = new Random(3);
  const middle = (kCorridor[0] + kCorridor[1]) / 2;
  const points: Point[] = [{ x: 1.5, y: middle }];
  const visit = (x: number, up: number, ahead: number) => {
    const wander = () => random.between(-0.25, 0.25);
    points.push({ x: x - 1.4 * ahead, y: middle + wander() }, { x: x - 0.1, y: middle + 0.6 * up });
    points.push(
      { x: x + wander(), y: middle + 3 * up },
      { x: x - 1.8 * ahead, y: middle + 4.5 * up },
    );
    points.push(
      { x: x - 0.6 * ahead, y: middle + 6.4 * up },
      { x: x + 1.6 * ahead, y: middle + 5.4 * up },
    );
    points.push({ x: x + 0.2, y: middle + 2.6 * up }, { x: x + 0.1, y: middle + 0.6 * up });
    points.push({ x: x + 1.5 * ahead, y: middle + wander() });
  };
  for (let x = kRoom / 2; x < kWidth; x += kRoom) visit(x, -1, 1);
  points.push({ x: kWidth - 1.5, y: middle });
  for (let x = kWidth - kRoom / 2; x > 0; x -= kRoom) visit(x, 1, -1);
  points.push({ x: 1.5, y: middle });
  return rounded(rounded(rounded(points)));
}

/** Corners cut (Chaikin 1974). */
function rounded(points: Point[]): Point[] {
  const out: Point[] = [points[0] as Point];
  for (let i = 1; i < points.length; i++) {
    const a = points[i - 1] as Point;
    const b = points[i] as Point;
    for (const share of [0.25, 0.75]) {
      out.push({ x: a.x + share * (b.x - a.x), y: a.y + share * (b.y - a.y) });
    }
  }
  out.push(points[points.length - 1] as Point);
  return out;
}

export interface Stop {
  t: number;
  pose: Pose;
  travelled: number;
}

/** Poses along a line, `step` metres apart, that turn no faster than a robot does. */
export function drive(points: Point[], step: number, speed: number, begin: number): Stop[] {
  const stops: Stop[] = [];
  let t = begin;
  let travelled = 0;
  let yaw = 0;
  for (let i = 1; i < points.length; i++) {
    const a = points[i - 1] as Point;
    const b = points[i] as Point;
    const length = Math.hypot(b.x - a.x, b.y - a.y);
    const wish = Math.atan2(b.y - a.y, b.x - a.x);
    const turn = Math.atan2(Math.sin(wish - yaw), Math.cos(wish - yaw));
    const turns = Math.floor(Math.abs(turn) / 0.35);
    for (let k = 1; k <= turns; k++) {
      t += 0.4;
      stops.push({ t, pose: { ...a, yaw: yaw + (turn * k) / (turns + 1) }, travelled });
    }
    yaw = wish;
    const steps = Math.max(1, Math.round(length / step));
    for (let k = 1; k <= steps; k++) {
      const share = k / steps;
      t += length / steps / speed;
      travelled += length / steps;
      const pose = { x: a.x + (b.x - a.x) * share, y: a.y + (b.y - a.y) * share, yaw };
      stops.push({ t, pose, travelled });
    }
  }
  return stops;
}
