/** Polygons that a reader draws: whether one is sound, how large, and where its name goes. */
import type { Point } from "../geometry.ts";

export const kMostCorners = 1000;
const kLeastArea = 1e-4;

/** Signed: positive counter-clockwise [m^2]. */
export function areaOf(corners: readonly Point[]): number {
  let sum = 0;
  corners.forEach((a, i) => {
    const b = corners[(i + 1) % corners.length] ?? a;
    sum += a.x * b.y - b.x * a.y;
  });
  return sum / 2;
}

/** Centre of gravity, or the mean of the corners where there is no area. */
export function middleOf(corners: readonly Point[]): Point {
  const [base = { x: 0, y: 0 }] = corners;
  // From the first corner on: maps may lie far from the origin of their frame.
  let [x, y, twice] = [0, 0, 0];
  corners.forEach((a, i) => {
    const b = corners[(i + 1) % corners.length] ?? a;
    const cross = (a.x - base.x) * (b.y - base.y) - (b.x - base.x) * (a.y - base.y);
    x += (a.x + b.x - 2 * base.x) * cross;
    y += (a.y + b.y - 2 * base.y) * cross;
    twice += cross;
  });
  if (Math.abs(twice) > 1e-9) return { x: base.x + x / (3 * twice), y: base.y + y / (3 * twice) };
  const count = Math.max(1, corners.length);
  const sum = corners.reduce((all, p) => ({ x: all.x + p.x, y: all.y + p.y }), { x: 0, y: 0 });
  return { x: sum.x / count, y: sum.y / count };
}

function side(a: Point, b: Point, p: Point): number {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

function cross(a: Point, b: Point, c: Point, d: Point): boolean {
  const [p, q] = [side(a, b, c), side(a, b, d)];
  const [r, s] = [side(c, d, a), side(c, d, b)];
  return p * q < 0 && r * s < 0;
}

/** What is wrong with it, in words; null where it is sound. Cost: the square of the corners. */
export function faultOf(corners: readonly Point[]): string | null {
  const n = corners.length;
  if (n < 3) return "A polygon has three corners at least.";
  if (n > kMostCorners) return `A polygon has ${kMostCorners} corners at most.`;
  for (let i = 0; i < n; i++) {
    for (let j = i + 2; j < n; j++) {
      if (i === 0 && j === n - 1) continue;
      const [a, b] = [corners[i], corners[(i + 1) % n]];
      const [c, d] = [corners[j], corners[(j + 1) % n]];
      if (a && b && c && d && cross(a, b, c, d)) return "Sides of the polygon cross each other.";
    }
  }
  return Math.abs(areaOf(corners)) < kLeastArea ? "The polygon has no ground within." : null;
}
