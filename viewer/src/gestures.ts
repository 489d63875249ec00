/** Pointers and the wheel as the map understands them. */
import type { Point } from "./geometry.ts";

/** Takes what one pointer does from here on, in place of the map. */
export interface Drag {
  move(at: Point, before: Point): void;
  /** `meant` unless a second finger came, or the browser took the pointer away. */
  end(meant: boolean): void;
}

export interface GestureTarget {
  /** Null where a drag from here is the map's own. */
  grab(at: Point, turning: boolean): Drag | null;
  pan(dx: number, dy: number): void;
  zoom(at: Point, factor: number, turn: number): void;
  click(at: Point): void;
  doubleClick(at: Point): void;
  hover(at: Point | null): void;
}

const kClickSlop = 5;
/** Two fingers turn the view only once they have clearly turned [rad]. */
const kTurnSlop = 0.2;

export class Gestures {
  private readonly pointers = new Map<number, Point>();
  private moved = 0;
  private turning = false;
  private turned = 0;
  private touches = 0;
  private drag: Drag | null = null;

  constructor(
    private readonly element: HTMLElement,
    private readonly target: GestureTarget,
  ) {
    element.addEventListener("pointerdown", (event) => this.down(event));
    element.addEventListener("pointermove", (event) => this.move(event));
    element.addEventListener("pointerup", (event) => this.up(event, true));
    element.addEventListener("pointercancel", (event) => this.up(event, false));
    element.addEventListener("pointerleave", () => target.hover(null));
    element.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    element.addEventListener("contextmenu", (event) => event.preventDefault());
    element.addEventListener("dblclick", (event) => target.doubleClick(this.placeOf(event)));
  }

  private placeOf(event: MouseEvent): Point {
    const box = this.element.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  private down(event: PointerEvent): void {
    if (this.pointers.size === 0) {
      this.moved = this.turned = this.touches = 0;
      this.turning = event.shiftKey || event.button === 1 || event.button === 2;
      this.drag = this.target.grab(this.placeOf(event), this.turning);
    } else {
      this.endDrag(false);
    }
    this.pointers.set(event.pointerId, this.placeOf(event));
    this.touches = Math.max(this.touches, this.pointers.size);
    this.element.setPointerCapture(event.pointerId);
    this.element.focus({ preventScroll: true });
  }

  private move(event: PointerEvent): void {
    const now = this.placeOf(event);
    const before = this.pointers.get(event.pointerId);
    if (event.pointerType === "mouse") this.target.hover(now);
    if (before === undefined) return;
    this.pointers.set(event.pointerId, now);
    const dx = now.x - before.x;
    const dy = now.y - before.y;
    this.moved += Math.abs(dx) + Math.abs(dy);
    if (this.pointers.size === 2) this.pinch(event.pointerId, before, now);
    else if (this.pointers.size === 1 && (this.moved > kClickSlop || this.touches > 1)) {
      if (this.drag !== null) this.drag.move(now, before);
      else if (this.turning) this.turnAboutMiddle(before, now);
      else this.target.pan(dx, dy);
    }
  }

  private pinch(id: number, before: Point, now: Point): void {
    const other = [...this.pointers].find(([key]) => key !== id)?.[1];
    if (other === undefined) return;
    const was = Math.hypot(before.x - other.x, before.y - other.y);
    const is = Math.hypot(now.x - other.x, now.y - other.y);
    if (was < 1 || is < 1) return;
    const angle = (p: Point) => Math.atan2(-(p.y - other.y), p.x - other.x);
    const turn = Math.atan2(
      Math.sin(angle(now) - angle(before)),
      Math.cos(angle(now) - angle(before)),
    );
    this.turned += turn;
    const middle = { x: (now.x + other.x) / 2, y: (now.y + other.y) / 2 };
    this.target.pan((now.x - before.x) / 2, (now.y - before.y) / 2);
    this.target.zoom(middle, is / was, Math.abs(this.turned) > kTurnSlop ? turn : 0);
  }

  private turnAboutMiddle(before: Point, now: Point): void {
    const middle = { x: this.element.clientWidth / 2, y: this.element.clientHeight / 2 };
    const angle = (p: Point) => Math.atan2(-(p.y - middle.y), p.x - middle.x);
    this.target.zoom(middle, 1, angle(now) - angle(before));
  }

  private up(event: PointerEvent, meant: boolean): void {
    const known = this.pointers.delete(event.pointerId);
    const click = known && meant && this.moved <= kClickSlop && this.touches === 1;
    if (known) this.endDrag(meant && !click);
    if (click && event.button === 0 && this.pointers.size === 0) {
      this.target.click(this.placeOf(event));
    }
  }

  private endDrag(meant: boolean): void {
    const { drag } = this;
    this.drag = null;
    drag?.end(meant);
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    const unit = event.deltaMode === 1 ? 16 : event.deltaMode === 2 ? 400 : 1;
    const delta = Math.min(400, Math.max(-400, event.deltaY * unit));
    const rate = event.ctrlKey ? 0.01 : 0.0015;
    this.target.zoom(this.placeOf(event), Math.exp(-delta * rate), 0);
  }
}
