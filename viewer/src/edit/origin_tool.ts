import type { Camera } from "../camera.ts";
import { origin } from "../edit_toml.ts";
import { distance, type Point, wrapAngle } from "../geometry.ts";
import type { Drag } from "../gestures.ts";
import type { Overlay } from "../overlay.ts";
import { drawHeading, drawPlace } from "./draw.ts";
import { kTurn, type MapTool } from "./map_tool.ts";

/** A drag shorter than that on the screen tells no heading. */
const kLeastDrag = 12;
const kArrow = 60;

/** Where the frame begins, and, when it is dragged, where x points. */
export class OriginTool implements MapTool {
  point: Point | null = null;
  yaw: number | null = null;

  constructor(private readonly changed: () => void) {}

  instruction(): string {
    if (this.point === null) return "Click the point, and drag on to where x shall point.";
    return "This becomes (0, 0). Click or drag anew, [ and ] turn; then add it.";
  }

  set(point: Point | null, yaw: number | null): void {
    this.point = point;
    this.yaw = yaw === null ? null : wrapAngle(yaw);
    this.changed();
  }

  click(at: Point, camera: Camera): void {
    this.set(camera.toWorld(at), null);
  }

  doubleClick(): void {}

  grab(at: Point, turning: boolean, camera: Camera): Drag | null {
    if (turning) return null;
    const before = { point: this.point, yaw: this.yaw };
    const point = camera.toWorld(at);
    return {
      move: (now) => {
        const p = camera.toWorld(now);
        const far = distance(at, now) >= kLeastDrag;
        this.set(point, far ? Math.atan2(p.y - point.y, p.x - point.x) : null);
      },
      end: (meant) => {
        if (!meant) this.set(before.point, before.yaw);
      },
    };
  }

  key(event: KeyboardEvent): boolean {
    const step: Record<string, number> = { "[": kTurn, "]": -kTurn };
    const by = step[event.key];
    if (by === undefined || this.point === null) return false;
    this.set(this.point, (this.yaw ?? 0) + by);
    return true;
  }

  takeBack(): boolean {
    if (this.point === null) return false;
    if (this.yaw !== null) this.set(this.point, null);
    else this.set(null, null);
    return true;
  }

  cursor(): string {
    return "crosshair";
  }

  draw(overlay: Overlay): void {
    if (this.point === null) return;
    const { accent } = overlay.palette;
    if (this.yaw !== null) drawHeading(overlay, { ...this.point, yaw: this.yaw }, kArrow, accent);
    drawPlace(overlay, this.point, this.yaw === null ? "(0, 0)" : "(0, 0), x", accent);
  }

  problem(): string | null {
    return this.point === null ? "Choose the point." : null;
  }

  toml(): string {
    return origin(this.point ?? { x: 0, y: 0 }, this.yaw);
  }
}
