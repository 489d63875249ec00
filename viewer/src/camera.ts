/** What part of the map is seen: the centre, pixels a metre, and the turn of the view. */
import { type Box, include, emptyBox, isEmpty, type Point, wrapAngle } from "./geometry.ts";

const kLeastScale = 0.02;
const kLargestScale = 4000;

export class Camera {
  x = 0;
  y = 0;
  /** CSS pixels a metre. */
  scale = 20;
  /** By which the map is turned on the screen, counter-clockwise. */
  angle = 0;
  width = 1;
  height = 1;

  toScreen(p: Point): Point {
    const c = Math.cos(this.angle) * this.scale;
    const s = Math.sin(this.angle) * this.scale;
    const dx = p.x - this.x;
    const dy = p.y - this.y;
    return { x: this.width / 2 + c * dx - s * dy, y: this.height / 2 - s * dx - c * dy };
  }

  toWorld(p: Point): Point {
    const c = Math.cos(this.angle) / this.scale;
    const s = Math.sin(this.angle) / this.scale;
    const dx = p.x - this.width / 2;
    const dy = this.height / 2 - p.y;
    return { x: this.x + c * dx + s * dy, y: this.y - s * dx + c * dy };
  }

  /** Moves the map by pixels. */
  pan(dx: number, dy: number): void {
    const at = this.toWorld({ x: this.width / 2 - dx, y: this.height / 2 - dy });
    this.x = at.x;
    this.y = at.y;
  }

  /** Zooms and turns about a place of the screen, which stays where it is. */
  zoomAt(p: Point, factor: number, turn = 0): void {
    const fixed = this.toWorld(p);
    this.scale = Math.min(kLargestScale, Math.max(kLeastScale, this.scale * factor));
    this.angle = wrapAngle(this.angle + turn);
    const now = this.toWorld(p);
    this.x += fixed.x - now.x;
    this.y += fixed.y - now.y;
  }

  /** What is seen, as a box on the map's axes. */
  seen(): Box {
    const box = emptyBox();
    for (const x of [0, this.width]) {
      for (const y of [0, this.height]) {
        const p = this.toWorld({ x, y });
        include(box, p.x, p.y);
      }
    }
    return box;
  }

  /**
   * Centre and scale that show all of a box at the present turn, beside `left` and above `below`
   * pixels that something else covers.
   */
  fitting(box: Box, left = 0, below = 0, margin = 24): { x: number; y: number; scale: number } {
    if (isEmpty(box)) return { x: this.x, y: this.y, scale: this.scale };
    const c = Math.abs(Math.cos(this.angle));
    const s = Math.abs(Math.sin(this.angle));
    const w = Math.max(box.right - box.left, 0.5);
    const h = Math.max(box.top - box.bottom, 0.5);
    const across = Math.max(this.width - left - 2 * margin, 1) / (c * w + s * h);
    const up = Math.max(this.height - below - 2 * margin, 1) / (s * w + c * h);
    const scale = Math.min(kLargestScale, Math.max(kLeastScale, Math.min(across, up)));
    const aside = left / 2 / scale;
    const down = below / 2 / scale;
    const [cos, sin] = [Math.cos(this.angle), Math.sin(this.angle)];
    const x = (box.left + box.right) / 2 - aside * cos - down * sin;
    return { x, y: (box.bottom + box.top) / 2 + aside * sin - down * cos, scale };
  }
}
