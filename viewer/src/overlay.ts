/** What is drawn over the map by hand: the robot, measured lines, the scale. */
import type { Camera } from "./camera.ts";
import { type Palette } from "./colours.ts";
import { metres } from "./format.ts";
import { type Point, roundLength } from "./geometry.ts";
import type { Measure } from "./measure.ts";
import type { RobotState } from "./model.ts";

/** Of a normal distribution in the plane, 95 % lie within as many standard deviations. */
const kSigmas95 = 2.4477;
const kFont = '12px system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';

export class Overlay {
  constructor(
    readonly context: CanvasRenderingContext2D,
    readonly camera: Camera,
    readonly palette: Palette,
  ) {}

  begin(pixelRatio: number): void {
    const { context, camera } = this;
    context.setTransform(pixelRatio, 0, 0, pixelRatio, 0, 0);
    context.clearRect(0, 0, camera.width, camera.height);
    context.font = kFont;
    context.lineJoin = context.lineCap = "round";
  }

  robot({ pose, ellipse, yawSigma }: RobotState): void {
    const { context, camera, palette } = this;
    const at = camera.toScreen(pose);
    const size = Math.max(10, 0.3 * camera.scale);
    const heading = -(pose.yaw + camera.angle);
    context.save();
    context.translate(at.x, at.y);
    if (ellipse !== null) {
      const radius = (value: number) => value * kSigmas95 * camera.scale;
      context.beginPath();
      const turn = -(ellipse.angle + camera.angle);
      context.ellipse(0, 0, radius(ellipse.major), radius(ellipse.minor), turn, 0, 2 * Math.PI);
      this.wash(palette.accent);
      const spread = Math.min(Math.PI, kSigmas95 * yawSigma);
      if (spread > 0.1) {
        context.beginPath();
        context.moveTo(0, 0);
        context.arc(0, 0, size * 2.2, heading - spread, heading + spread);
        context.closePath();
        this.wash(palette.accent);
      }
    }
    context.rotate(heading);
    context.beginPath();
    context.moveTo(size, 0);
    context.lineTo(-size * 0.72, size * 0.68);
    context.lineTo(-size * 0.36, 0);
    context.lineTo(-size * 0.72, -size * 0.68);
    context.closePath();
    context.fillStyle = palette.robot;
    context.strokeStyle = palette.robotEdge;
    context.lineWidth = 2;
    context.fill();
    context.stroke();
    context.restore();
  }

  private wash(colour: string): void {
    const { context } = this;
    context.fillStyle = colour;
    context.strokeStyle = colour;
    context.lineWidth = 1.5;
    context.globalAlpha = 0.22;
    context.fill();
    context.globalAlpha = 1;
    context.stroke();
  }

  measure(measure: Measure, pointer: Point | null): void {
    const { context, camera, palette } = this;
    const points = measure.points.map((p) => camera.toScreen(p));
    const open = measure.active && !measure.finished && pointer !== null && points.length > 0;
    context.lineWidth = 2;
    const trace = () => {
      context.beginPath();
      points.forEach((p, i) => (i === 0 ? context.moveTo(p.x, p.y) : context.lineTo(p.x, p.y)));
      context.stroke();
    };
    context.strokeStyle = palette.halo;
    context.lineWidth = 5;
    trace();
    context.strokeStyle = palette.accent;
    context.lineWidth = 2;
    trace();
    const last = points[points.length - 1];
    if (open && last !== undefined) {
      context.setLineDash([5, 5]);
      context.beginPath();
      context.moveTo(last.x, last.y);
      context.lineTo(pointer.x, pointer.y);
      context.stroke();
      context.setLineDash([]);
    }
    context.fillStyle = palette.halo;
    for (const p of points) {
      context.beginPath();
      context.arc(p.x, p.y, 4, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
    }
    points.forEach((p, i) => {
      const before = points[i - 1];
      if (before === undefined) return;
      this.label(metres(measure.segment(i)), (p.x + before.x) / 2, (p.y + before.y) / 2 - 10);
    });
    if (points.length > 2 && last !== undefined) {
      this.label(`Σ ${metres(measure.total)}`, last.x, last.y + 18);
    }
  }

  /** A cross in the middle: where Enter acts when the map is used by keyboard. */
  crosshair(): void {
    const { context, camera, palette } = this;
    const x = Math.round(camera.width / 2) + 0.5;
    const y = Math.round(camera.height / 2) + 0.5;
    const trace = (colour: string, width: number) => {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.beginPath();
      for (const [dx, dy] of [
        [1, 0],
        [-1, 0],
        [0, 1],
        [0, -1],
      ] as const) {
        context.moveTo(x + 4 * dx, y + 4 * dy);
        context.lineTo(x + 11 * dx, y + 11 * dy);
      }
      context.stroke();
    };
    trace(palette.halo, 4);
    trace(palette.ink, 1.5);
  }

  scaleBar(left: number, bottom: number): void {
    const { context, camera, palette } = this;
    const length = roundLength(120 / camera.scale);
    const width = length * camera.scale;
    const y = camera.height - bottom;
    const trace = (colour: string, line: number) => {
      context.strokeStyle = colour;
      context.lineWidth = line;
      context.beginPath();
      context.moveTo(left, y - 5);
      context.lineTo(left, y);
      context.lineTo(left + width, y);
      context.lineTo(left + width, y - 5);
      context.stroke();
    };
    trace(palette.halo, 5);
    trace(palette.ink, 1.75);
    const text =
      length >= 1000
        ? `${length / 1000} km`
        : length >= 1
          ? `${length} m`
          : `${Math.round(length * 1000) / 10} cm`;
    this.label(text, left + width / 2, y - 12);
  }

  label(text: string, x: number, y: number): void {
    const { context, palette } = this;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.strokeStyle = palette.halo;
    context.lineWidth = 4;
    context.strokeText(text, x, y);
    context.fillStyle = palette.ink;
    context.fillText(text, x, y);
  }
}
