import { bearing, distance, type Point } from "./geometry.ts";
import { metres } from "./format.ts";

/** A line through places that the reader sets: its lengths and directions. */
export class Measure {
  active = false;
  readonly points: Point[] = [];
  /** Whether the line is done; the next place then begins another. */
  private done = false;

  add(p: Point): void {
    if (this.done) this.clear();
    this.points.push(p);
  }

  /** Takes back the last place. */
  undo(): void {
    this.points.pop();
    this.done = false;
  }

  finish(): void {
    this.done = this.points.length > 0;
  }

  clear(): void {
    this.points.length = 0;
    this.done = false;
  }

  get finished(): boolean {
    return this.done;
  }

  get total(): number {
    let sum = 0;
    for (let i = 1; i < this.points.length; i++) sum += this.segment(i);
    return sum;
  }

  segment(i: number): number {
    const [a, b] = [this.points[i - 1], this.points[i]];
    return a && b ? distance(a, b) : 0;
  }

  /** Of the last line, where there is one. */
  get lastBearing(): number | null {
    const [a, b] = this.points.slice(-2);
    return a && b ? bearing(a, b) : null;
  }

  describe(): string {
    if (this.points.length === 0) return "Set the first point.";
    const last = this.lastBearing;
    if (last === null) return "Set the next point.";
    const length = this.segment(this.points.length - 1);
    const direct = `${metres(length)} at ${last.toFixed(1)}°`;
    return this.points.length === 2 ? direct : `${metres(this.total)} in all, last ${direct}`;
  }
}
