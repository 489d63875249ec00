import type { Camera } from "../camera.ts";
import { polygonEdit, type PolygonKind, type SpeedLimit } from "../edit_toml.ts";
import { distance, type Point } from "../geometry.ts";
import type { Drag } from "../gestures.ts";
import type { Overlay } from "../overlay.ts";
import { drawDraft } from "./draw.ts";
import { kCornerReach, type MapTool } from "./map_tool.ts";
import { faultOf } from "./polygon.ts";

/** Two clicks that close are one: the second of a double click adds no corner. */
const kSame = 4;

/** A polygon by clicks, or a box by dragging; a closed one's corners can be moved. */
export class PolygonTool implements MapTool {
  /** In the map's frame. */
  points: Point[] = [];
  closed = false;
  /** The next drag is a box, also without Shift. */
  boxing = false;
  name = "";
  percent = "50";
  limit = "";
  private lastByKey = false;

  constructor(
    readonly kind: PolygonKind,
    private readonly changed: () => void,
  ) {}

  instruction(): string {
    const fault = this.closed ? faultOf(this.points) : null;
    if (fault !== null) return `${fault} Move a corner, or take one back.`;
    if (this.closed) return "Closed. Corners can be moved; then add it.";
    if (this.boxing) return "Drag from one corner of the box to the other.";
    if (this.points.length === 0) return "Click the first corner, or drag a box with Shift.";
    if (this.points.length < 3) return "Click the next corner. Backspace takes one back.";
    return "Click on, or close it: a double click, Enter, or a click on the first corner.";
  }

  click(at: Point, camera: Camera, byKey: boolean): void {
    if (this.closed) return;
    const near = (p: Point | undefined, reach: number) =>
      p !== undefined && distance(camera.toScreen(p), at) <= reach;
    this.lastByKey = byKey;
    const last = this.points[this.points.length - 1];
    if (this.points.length >= 3 && near(this.points[0], kCornerReach)) this.close();
    else if (near(last, kSame)) {
      // By keyboard there is no double click: Enter again in the same place closes.
      if (byKey) this.close();
    } else this.points.push(camera.toWorld(at));
    this.changed();
  }

  doubleClick(): void {
    this.close();
  }

  close(): void {
    if (this.points.length >= 3) this.closed = true;
    this.changed();
  }

  clear(): void {
    this.points = [];
    this.closed = false;
    this.changed();
  }

  takeBack(): boolean {
    if (this.closed) this.closed = false;
    else if (this.points.pop() === undefined) return false;
    this.changed();
    return true;
  }

  private cornerAt(at: Point, camera: Camera): number {
    return this.points.findIndex((p) => distance(camera.toScreen(p), at) <= kCornerReach);
  }

  grab(at: Point, turning: boolean, camera: Camera): Drag | null {
    if (turning || this.boxing) return this.box(at, camera);
    const corner = this.closed ? this.cornerAt(at, camera) : -1;
    if (corner < 0) return null;
    return {
      move: (now) => {
        this.points[corner] = camera.toWorld(now);
        this.changed();
      },
      end: () => undefined,
    };
  }

  /** Along the screen's axes, which a turned view's map lies askew to. */
  private box(from: Point, camera: Camera): Drag {
    const before = { points: this.points, closed: this.closed };
    let moved = false;
    return {
      move: (to) => {
        const corners = [from, { x: to.x, y: from.y }, to, { x: from.x, y: to.y }];
        this.points = corners.map((p) => camera.toWorld(p));
        this.closed = moved = true;
        this.changed();
      },
      end: (meant) => {
        if (!meant || faultOf(this.points) !== null) Object.assign(this, before);
        else if (moved) this.boxing = false;
        this.changed();
      },
    };
  }

  key(event: KeyboardEvent): boolean {
    // By mouse Enter closes; by keyboard it sets the corner in the middle, as in measuring.
    if (event.key !== "Enter" || this.lastByKey || this.points.length < 3) return false;
    this.close();
    return true;
  }

  cursor(at: Point, camera: Camera): string {
    return this.closed ? (this.cornerAt(at, camera) >= 0 ? "move" : "") : "crosshair";
  }

  draw(overlay: Overlay, pointer: Point | null): void {
    if (this.points.length > 0) drawDraft(overlay, this.points, this.kind, this.closed, pointer);
  }

  /** Why it can't be sent; null when it can. */
  problem(): string | null {
    if (!this.closed) return "Draw the polygon, and close it.";
    return faultOf(this.points) ?? (this.kind === "speed" ? this.limitProblem() : null);
  }

  private limitProblem(): string | null {
    const [percent, limit] = [this.percent.trim(), this.limit.trim()];
    if ((percent === "") === (limit === "")) return "Tell the speed in percent or in m/s.";
    if (percent !== "" && !(numberIn(percent) >= 1 && numberIn(percent) <= 100))
      return "The speed is from 1 to 100 percent.";
    if (limit !== "" && !(numberIn(limit) >= 0.001 && numberIn(limit) <= 1000))
      return "The speed is from 0.001 to 1000 m/s.";
    return null;
  }

  toml(): string {
    let limit: SpeedLimit | null = null;
    if (this.kind === "speed") {
      const percent = this.percent.trim();
      limit =
        percent !== "" ? { percent: numberIn(percent) } : { metresPerSecond: numberIn(this.limit) };
    }
    const named = this.kind === "keep_out" || this.kind === "speed";
    return polygonEdit(this.kind, this.points, named ? this.name.trim() : "", limit);
  }
}

/** As a reader writes it: with a point or a comma; NaN where it is none. */
export function numberIn(text: string): number {
  const plain = text.trim().replace(",", ".");
  return /^[-+]?(\d+\.?\d*|\.\d+)$/.test(plain) ? Number(plain) : NaN;
}
