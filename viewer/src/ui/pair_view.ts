import type { Palette } from "../colours.ts";
import {
  apply,
  type Box,
  compose,
  emptyBox,
  include,
  isEmpty,
  kIdentity,
  type Pose,
} from "../geometry.ts";
import type { Evidence } from "../json_messages.ts";

/** Both scans of a closure on top of each other: dots for the first, crosses for the second. */
export class PairView {
  private evidence: Evidence | null = null;
  private asMeasured = true;
  private base: Pose = kIdentity;
  private box: Box = emptyBox();

  constructor(
    readonly canvas: HTMLCanvasElement,
    private readonly palette: () => Palette,
  ) {}

  /** Turned by the first scan's heading, so that the picture lies as the map does. */
  show(evidence: Evidence | null, asMeasured: boolean, heading: number): void {
    this.evidence = evidence;
    this.base = { x: 0, y: 0, yaw: heading };
    this.asMeasured = asMeasured;
    this.box = emptyBox();
    if (evidence !== null) {
      // One frame for both, so that switching moves nothing but the second scan.
      for (const pose of [evidence.measured, evidence.graph])
        this.includeScan(evidence.to.points, compose(this.base, pose));
      this.includeScan(evidence.from.points, this.base);
    }
    this.draw();
  }

  private includeScan(points: number[], pose: Pose): void {
    for (let i = 0; i + 1 < points.length; i += 2) {
      const p = apply(pose, { x: points[i] ?? 0, y: points[i + 1] ?? 0 });
      include(this.box, p.x, p.y);
    }
    include(this.box, pose.x, pose.y);
  }

  draw(): void {
    const { canvas, evidence, box } = this;
    const context = canvas.getContext("2d");
    const ratio = Math.min(3, window.devicePixelRatio || 1);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (context === null || width === 0) return;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    context.scale(ratio, ratio);
    if (evidence === null || isEmpty(box)) return;
    const margin = 12;
    const across = (width - 2 * margin) / Math.max(box.right - box.left, 0.5);
    const up = (height - 2 * margin) / Math.max(box.top - box.bottom, 0.5);
    const scale = Math.min(across, up);
    const middle = { x: (box.left + box.right) / 2, y: (box.bottom + box.top) / 2 };
    const place = (pose: Pose, x: number, y: number) => {
      const p = apply(pose, { x, y });
      return { x: width / 2 + (p.x - middle.x) * scale, y: height / 2 - (p.y - middle.y) * scale };
    };
    const from = this.base;
    const to = compose(from, this.asMeasured ? evidence.measured : evidence.graph);
    const [first = "", second = ""] = this.palette().drives;
    this.scan(context, evidence.from.points, (x, y) => place(from, x, y), first, false);
    this.scan(context, evidence.to.points, (x, y) => place(to, x, y), second, true);
    this.robot(context, place(from, 0, 0), from.yaw, first);
    this.robot(context, place(to, 0, 0), to.yaw, second);
  }

  private scan(
    context: CanvasRenderingContext2D,
    points: number[],
    place: (x: number, y: number) => { x: number; y: number },
    colour: string,
    crosses: boolean,
  ): void {
    context.strokeStyle = context.fillStyle = colour;
    context.lineWidth = 1.2;
    context.beginPath();
    for (let i = 0; i + 1 < points.length; i += 2) {
      const { x, y } = place(points[i] ?? 0, points[i + 1] ?? 0);
      if (crosses) {
        context.moveTo(x - 2.2, y - 2.2);
        context.lineTo(x + 2.2, y + 2.2);
        context.moveTo(x - 2.2, y + 2.2);
        context.lineTo(x + 2.2, y - 2.2);
      } else {
        context.moveTo(x + 1.7, y);
        context.arc(x, y, 1.7, 0, 2 * Math.PI);
      }
    }
    if (crosses) context.stroke();
    else context.fill();
  }

  private robot(
    context: CanvasRenderingContext2D,
    at: { x: number; y: number },
    yaw: number,
    colour: string,
  ): void {
    context.save();
    context.translate(at.x, at.y);
    context.rotate(-yaw);
    context.beginPath();
    context.moveTo(9, 0);
    context.lineTo(-6, 6);
    context.lineTo(-3, 0);
    context.lineTo(-6, -6);
    context.closePath();
    context.fillStyle = colour;
    context.fill();
    context.restore();
  }
}
