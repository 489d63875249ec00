/** Edits as they lie on the map: kinds are told by pattern and edge, not by colour alone. */
import type { EditState } from "../edits.ts";
import { kPolygonKinds, type PolygonKind } from "../edit_toml.ts";
import { apply, type Point, type Pose } from "../geometry.ts";
import type { Overlay } from "../overlay.ts";
import type { Track } from "../track.ts";
import { zoneName } from "../words.ts";
import { middleOf } from "./polygon.ts";

const kHatch = 9;
/** Dashes of the edge, by kind. */
const kEdges: Record<PolygonKind, number[]> = {
  crop: [10, 5],
  erase: [2, 4],
  keep_out: [],
  speed: [7, 3, 2, 3],
};

function trace({ context }: Overlay, points: readonly Point[], closed: boolean): void {
  context.beginPath();
  points.forEach(({ x, y }, i) => (i === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  if (closed) context.closePath();
}

/** Lines across what is clipped, `slope` pixels aside for each pixel down. */
function hatch({ context, camera }: Overlay, points: readonly Point[], slope: number): void {
  const clamp = (value: number, most: number) => Math.min(most, Math.max(0, value));
  const xs = points.map(({ x }) => clamp(x, camera.width));
  const ys = points.map(({ y }) => clamp(y, camera.height));
  const [left, right] = [Math.min(...xs), Math.max(...xs)];
  const [top, bottom] = [Math.min(...ys), Math.max(...ys)];
  context.beginPath();
  if (slope === 0) {
    for (let y = Math.ceil(top / kHatch) * kHatch; y <= bottom; y += kHatch) {
      context.moveTo(left, y);
      context.lineTo(right, y);
    }
  } else {
    // x = c + slope y, for each multiple c of the step that meets the box.
    const low = left - Math.max(slope * top, slope * bottom);
    const high = right - Math.min(slope * top, slope * bottom);
    for (let c = Math.ceil(low / kHatch) * kHatch; c <= high; c += kHatch) {
      context.moveTo(c + slope * top, top);
      context.lineTo(c + slope * bottom, bottom);
    }
  }
  context.stroke();
}

function fill(overlay: Overlay, points: readonly Point[], kind: PolygonKind): void {
  const { context, palette } = overlay;
  const colour = palette.edits[kind];
  context.save();
  trace(overlay, points, true);
  context.clip();
  context.fillStyle = context.strokeStyle = colour;
  context.globalAlpha = 0.16;
  if (kind !== "crop") context.fill();
  context.globalAlpha = 0.6;
  context.lineWidth = 1.25;
  if (kind === "keep_out") {
    hatch(overlay, points, 1);
    hatch(overlay, points, -1);
  } else if (kind === "speed") {
    hatch(overlay, points, 1);
  } else if (kind === "erase") {
    context.lineWidth = 2;
    context.setLineDash([0.1, kHatch]);
    hatch(overlay, points, 0);
  }
  context.restore();
}

function edge(overlay: Overlay, points: readonly Point[], kind: PolygonKind, width: number): void {
  const { context, palette } = overlay;
  context.save();
  context.lineCap = "butt";
  trace(overlay, points, true);
  context.strokeStyle = palette.halo;
  context.lineWidth = width + 3;
  context.stroke();
  context.strokeStyle = palette.edits[kind];
  context.lineWidth = width;
  context.setLineDash(kEdges[kind]);
  context.stroke();
  context.restore();
}

/** Corners in the map's frame. */
export function drawPolygon(
  overlay: Overlay,
  corners: readonly Point[],
  kind: PolygonKind,
  name: string,
): void {
  const points = corners.map((p) => overlay.camera.toScreen(p));
  fill(overlay, points, kind);
  edge(overlay, points, kind, 2);
  const at = overlay.camera.toScreen(middleOf(corners));
  // A crop is around everything: its name stands at its edge, out of the way.
  const top = points.reduce((best, p) => (p.y < best.y ? p : best), points[0] ?? at);
  const [x, y] = kind === "crop" ? [top.x, top.y - 10] : [at.x, at.y];
  overlay.label(name, x, y);
}

function cornersOf(polygon: number[]): Point[] {
  return Array.from({ length: polygon.length >> 1 }, (_, i) => ({
    x: polygon[2 * i] ?? 0,
    y: polygon[2 * i + 1] ?? 0,
  }));
}

export function drawEdits(overlay: Overlay, state: EditState): void {
  for (const { kind, applied, polygon, toml } of state.edits) {
    const known = kPolygonKinds.find((one) => one === kind);
    if (known === undefined || !applied || polygon.length < 6) continue;
    drawPolygon(overlay, cornersOf(polygon), known, zoneName(known, toml));
  }
}

/** A polygon that is being drawn: its corners, and where the next one would be. */
export function drawDraft(
  overlay: Overlay,
  corners: readonly Point[],
  kind: PolygonKind,
  closed: boolean,
  pointer: Point | null,
): void {
  const { context, camera, palette } = overlay;
  const points = corners.map((p) => camera.toScreen(p));
  const open = !closed && pointer !== null ? [...points, pointer] : points;
  if (open.length > 2) fill(overlay, open, kind);
  if (closed) edge(overlay, points, kind, 2.5);
  else line(overlay, points, palette.edits[kind], 2.5);
  const [first] = points;
  const last = points[points.length - 1];
  context.strokeStyle = palette.edits[kind];
  context.lineWidth = 2;
  if (!closed && pointer !== null && last !== undefined && first !== undefined) {
    context.setLineDash([5, 5]);
    trace(overlay, [last, pointer, first], false);
    context.stroke();
    context.setLineDash([]);
  }
  context.fillStyle = palette.halo;
  points.forEach((p, i) => {
    context.beginPath();
    context.arc(p.x, p.y, i === 0 && !closed ? 6 : 4, 0, 2 * Math.PI);
    context.fill();
    context.stroke();
  });
}

function line(overlay: Overlay, points: readonly Point[], colour: string, width: number): void {
  const { context, palette } = overlay;
  trace(overlay, points, false);
  context.strokeStyle = palette.halo;
  context.lineWidth = width + 3;
  context.stroke();
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.stroke();
}

/** A stretch of the path, drawn no finer than pixels. */
export function drawStretch(overlay: Overlay, track: Track, one: number, other: number): void {
  const { camera, palette } = overlay;
  const points: Point[] = [];
  for (let i = Math.min(one, other); i <= Math.max(one, other) && i < track.length; i++) {
    const p = camera.toScreen({ x: track.x(i), y: track.y(i) });
    const last = points[points.length - 1];
    const far = last === undefined || Math.hypot(p.x - last.x, p.y - last.y) > 2;
    if (far || i === Math.max(one, other)) points.push(p);
  }
  line(overlay, points, palette.edits.erase, 5);
}

/** A place of the path that was chosen, with its letter. */
export function drawPlace(overlay: Overlay, at: Point, letter: string, colour: string): void {
  const { context, camera, palette } = overlay;
  const p = camera.toScreen(at);
  context.beginPath();
  context.arc(p.x, p.y, 6, 0, 2 * Math.PI);
  context.fillStyle = colour;
  context.strokeStyle = palette.halo;
  context.lineWidth = 2;
  context.fill();
  context.stroke();
  overlay.label(letter, p.x, p.y - 16);
}

/** A scan from a pose, in the pattern of the pair view: dots of the first, crosses of the second. */
export function drawScan(
  overlay: Overlay,
  points: readonly number[],
  pose: Pose,
  colour: string,
  crosses: boolean,
): void {
  const { context, camera } = overlay;
  context.strokeStyle = context.fillStyle = colour;
  context.lineWidth = 1.5;
  context.beginPath();
  for (let i = 0; i + 1 < points.length; i += 2) {
    const p = camera.toScreen(apply(pose, { x: points[i] ?? 0, y: points[i + 1] ?? 0 }));
    if (crosses) {
      context.moveTo(p.x - 2.6, p.y - 2.6);
      context.lineTo(p.x + 2.6, p.y + 2.6);
      context.moveTo(p.x - 2.6, p.y + 2.6);
      context.lineTo(p.x + 2.6, p.y - 2.6);
    } else {
      context.moveTo(p.x + 2.2, p.y);
      context.arc(p.x, p.y, 2.2, 0, 2 * Math.PI);
    }
  }
  if (crosses) context.stroke();
  else context.fill();
}

/** An arrow with a length on the screen, from a place along a heading of the map. */
export function drawHeading(overlay: Overlay, pose: Pose, length: number, colour: string): void {
  const { context, camera, palette } = overlay;
  const at = camera.toScreen(pose);
  context.save();
  context.translate(at.x, at.y);
  context.rotate(-(pose.yaw + camera.angle));
  context.beginPath();
  context.moveTo(0, 0);
  context.lineTo(length, 0);
  context.moveTo(length - 8, -6);
  context.lineTo(length, 0);
  context.lineTo(length - 8, 6);
  context.strokeStyle = palette.halo;
  context.lineWidth = 6;
  context.stroke();
  context.strokeStyle = colour;
  context.lineWidth = 2.5;
  context.stroke();
  context.restore();
}
