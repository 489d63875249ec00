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

/** In and out of each room in turn, there along one side and back along the other. */
export function route(): Point[] {
  const middle = (kCorridor[0] + kCorridor[1]) / 2;
  const points: Point[] = [{ x: 2, y: middle }];
  const visit = (x: number, y: number) => {
    points.push({ x, y: middle }, { x, y }, { x: x + 0.3, y: middle });
  };
  for (let x = kRoom / 2; x < kWidth; x += kRoom) visit(x, 5.5);
  points.push({ x: kWidth - 1.5, y: middle });
  for (let x = kWidth - kRoom / 2; x > 0; x -= kRoom) visit(x, 18.5);
  points.push({ x: 2, y: middle });
  return points;
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
    const turns = Math.max(1, Math.ceil(Math.abs(turn) / 0.35));
    for (let k = 1; k <= turns; k++) {
      t += Math.abs(turn) / turns + 0.05;
      stops.push({ t, pose: { ...a, yaw: yaw + (turn * k) / turns }, travelled });
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
