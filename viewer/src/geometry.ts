/** Poses and shapes in the plane. Metres, radians, counter-clockwise, x right and y up. */

export interface Point {
  x: number;
  y: number;
}

export interface Pose {
  x: number;
  y: number;
  yaw: number;
}

export interface Box {
  left: number;
  bottom: number;
  right: number;
  top: number;
}

export const kIdentity: Pose = { x: 0, y: 0, yaw: 0 };

/** a_T_c of a_T_b and b_T_c. */
export function compose(a: Pose, b: Pose): Pose {
  const p = apply(a, b);
  return { x: p.x, y: p.y, yaw: wrapAngle(a.yaw + b.yaw) };
}

export function inverse(a: Pose): Pose {
  const c = Math.cos(a.yaw);
  const s = Math.sin(a.yaw);
  return { x: -c * a.x - s * a.y, y: s * a.x - c * a.y, yaw: wrapAngle(-a.yaw) };
}

export function apply(a: Pose, p: Point): Point {
  const c = Math.cos(a.yaw);
  const s = Math.sin(a.yaw);
  return { x: a.x + c * p.x - s * p.y, y: a.y + s * p.x + c * p.y };
}

/** Into (-pi, pi]. */
export function wrapAngle(angle: number): number {
  const turned = angle % (2 * Math.PI);
  if (turned > Math.PI) return turned - 2 * Math.PI;
  if (turned <= -Math.PI) return turned + 2 * Math.PI;
  return turned;
}

export function yawOf(x: number, y: number, z: number, w: number): number {
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

export function distance(a: Point, b: Point): number {
  return Math.hypot(b.x - a.x, b.y - a.y);
}

/** Direction from a to b in degrees, 0 along x, counter-clockwise, [0, 360). */
export function bearing(a: Point, b: Point): number {
  const degrees = (Math.atan2(b.y - a.y, b.x - a.x) * 180) / Math.PI;
  return degrees < 0 ? degrees + 360 : degrees;
}

export function distanceToSegment(p: Point, a: Point, b: Point): number {
  const dx = b.x - a.x;
  const dy = b.y - a.y;
  const square = dx * dx + dy * dy;
  const along = square > 0 ? ((p.x - a.x) * dx + (p.y - a.y) * dy) / square : 0;
  const t = Math.min(1, Math.max(0, along));
  return Math.hypot(p.x - a.x - t * dx, p.y - a.y - t * dy);
}

export interface Ellipse {
  major: number;
  minor: number;
  /** Of the major axis. */
  angle: number;
}

/** Half-axes of one standard deviation of a symmetric 2x2 covariance; negative parts count as 0. */
export function ellipseOf(xx: number, xy: number, yy: number): Ellipse {
  const mean = (xx + yy) / 2;
  const half = Math.hypot((xx - yy) / 2, xy);
  return {
    major: Math.sqrt(Math.max(0, mean + half)),
    minor: Math.sqrt(Math.max(0, mean - half)),
    angle: Math.atan2(2 * xy, xx - yy) / 2,
  };
}

export function emptyBox(): Box {
  return { left: Infinity, bottom: Infinity, right: -Infinity, top: -Infinity };
}

export function isEmpty(box: Box): boolean {
  return !(box.left <= box.right && box.bottom <= box.top);
}

export function include(box: Box, x: number, y: number): void {
  if (!Number.isFinite(x) || !Number.isFinite(y)) return;
  box.left = Math.min(box.left, x);
  box.right = Math.max(box.right, x);
  box.bottom = Math.min(box.bottom, y);
  box.top = Math.max(box.top, y);
}

export function overlap(a: Box, b: Box): boolean {
  return a.left <= b.right && b.left <= a.right && a.bottom <= b.top && b.bottom <= a.top;
}

/** The largest of 1, 2, 5 times a power of ten that is not above `length`. */
export function roundLength(length: number): number {
  if (!(length > 0) || !Number.isFinite(length)) return 1;
  const power = 10 ** Math.floor(Math.log10(length) + 1e-12);
  const ratio = length / power + 1e-9;
  return power * (ratio >= 5 ? 5 : ratio >= 2 ? 2 : 1);
}
