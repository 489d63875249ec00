/**
 * What of the model is drawn, for what is in sight: nothing that is out of it, and no more nodes,
 * lines and marks than pixels can show. A card would bear them all; a processor that has to draw in
 * its place would not.
 */
import { type Colour, colourOf, type Palette } from "./colours.ts";
import { type Box, overlap } from "./geometry.ts";
import { type Lines, type Marks, Pattern, Shape } from "./gl/shapes.ts";
import type { Closure, ClosureState, Submap } from "./json_messages.ts";
import { kClosureStates } from "./json_messages.ts";
import type { Settings } from "./settings.ts";
import { neededNodes } from "./simplify.ts";
import type { Track } from "./track.ts";

/** A part of the map, and how large a pixel is in it [m]. */
export interface Sight {
  box: Box;
  pixel: number;
}

const kPatterns: Record<ClosureState, Pattern> = {
  standing: Pattern.Solid,
  waiting: Pattern.Dotted,
  rejected: Pattern.Dashed,
  revoked: Pattern.DashDot,
};
const kShapes: Record<ClosureState, Shape> = {
  standing: Shape.Disc,
  waiting: Shape.Ring,
  rejected: Shape.Cross,
  revoked: Shape.Diamond,
};
/** Nodes that may be left out of the path lie closer to it than this, in pixels. */
const kTolerance = 0.35;
/** Colours of the path are true at least this often, in pixels. */
const kLongest = 24;
const kPathWidth = 2;
const kManyClosures = 1000;
/** A line between these lengths tells a closure without a mark, a shorter one not at all. */
const kShortLine = 14;
const kLongLine = 60;
const kSmallestOutline = 5;

function boxOf(ax: number, ay: number, bx: number, by: number): Box {
  return {
    left: Math.min(ax, bx),
    right: Math.max(ax, bx),
    bottom: Math.min(ay, by),
    top: Math.max(ay, by),
  };
}

/** Least and largest of what colours the path. */
export function rangeOfPath(track: Track, by: Settings["pathColour"]): [number, number] {
  if (track.length === 0) return [0, 0];
  const values = by === "time" ? track.t : track.sigma;
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < track.length; i++) {
    const value = values[i] ?? 0;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [by === "time" ? low : 0, high];
}

function pathColours(
  track: Track,
  by: Settings["pathColour"],
  ramp: Uint8Array,
  palette: Palette,
): (i: number) => Colour {
  const bytes = (colour: Colour): Colour => [colour[0] * 255, colour[1] * 255, colour[2] * 255];
  const drives = palette.drives.map((hex) => bytes(colourOf(hex)));
  if (by === "drive") return (i) => drives[(track.drives[i] ?? 0) % drives.length] ?? [0, 0, 0];
  const values = by === "time" ? track.t : track.sigma;
  const [low, high] = rangeOfPath(track, by);
  return (i) => {
    const share = high > low ? ((values[i] ?? 0) - low) / (high - low) : 0;
    const at = 3 * Math.round(255 * Math.min(1, Math.max(0, share)));
    return [ramp[at] ?? 0, ramp[at + 1] ?? 0, ramp[at + 2] ?? 0];
  };
}

export function fillPath(
  path: Lines,
  track: Track,
  by: Settings["pathColour"],
  ramp: Uint8Array,
  palette: Palette,
  { box, pixel }: Sight,
): void {
  const colour = pathColours(track, by, ramp, palette);
  const x = (i: number) => track.x(i);
  const y = (i: number) => track.y(i);
  const breaks = (i: number) => track.drives[i] !== track.drives[i - 1];
  const nodes = neededNodes(track.length, x, y, kTolerance * pixel, kLongest * pixel, breaks);
  path.clear();
  for (let k = 1; k < nodes.length; k++) {
    const a = nodes[k - 1] ?? 0;
    const b = nodes[k] ?? 0;
    const [ax, ay, bx, by] = [track.x(a), track.y(a), track.x(b), track.y(b)];
    if (track.drives[a] !== track.drives[b] || !overlap(boxOf(ax, ay, bx, by), box)) continue;
    path.addShaded(ax, ay, bx, by, colour(a), colour(b), 1, kPathWidth, Pattern.Joined);
  }
}

/** Tells lines apart that lie in other pixels; coordinates are counted in steps from the box's corner. */
class Seen {
  private readonly keys = new Set<number>();

  constructor(
    private readonly box: Box,
    private readonly step: number,
  ) {}

  private cell(value: number, from: number): number {
    return Math.min(2047, Math.max(0, Math.floor((value - from) / this.step)));
  }

  /** Whether it is the first of its kind there. */
  first(kind: number, ax: number, ay: number, bx: number, by: number): boolean {
    const { left, bottom } = this.box;
    const a = this.cell(ax, left) * 2048 + this.cell(ay, bottom);
    const b = this.cell(bx, left) * 2048 + this.cell(by, bottom);
    const key = (a * 2048 * 2048 + b) * 4 + kind;
    if (this.keys.has(key)) return false;
    this.keys.add(key);
    return true;
  }
}

export interface ClosureFill {
  closures: Closure[];
  track: Track;
  shown: Record<ClosureState, boolean>;
  selected: number | null;
  palette: Palette;
}

/** How many are in sight, drawn or merged with another. */
export function fillClosures(
  lines: Lines,
  marks: Marks,
  { closures, track, shown, selected, palette }: ClosureFill,
  { box, pixel }: Sight,
): number {
  lines.clear();
  marks.clear();
  const many = closures.length > kManyClosures;
  const size = many ? 6 : 8;
  const seenLines = new Seen(box, 3 * pixel);
  const seenMarks = new Seen(box, 4 * pixel);
  const colours = kClosureStates.map((state) => colourOf(palette.closures[state]));
  let count = 0;
  for (const { id, from, to, state } of closures) {
    const chosen = id === selected;
    if (!(from < track.length && to < track.length) || !(shown[state] || chosen)) continue;
    const [ax, ay, bx, by] = [track.x(from), track.y(from), track.x(to), track.y(to)];
    if (!overlap(boxOf(ax, ay, bx, by), box)) continue;
    count++;
    const kind = kClosureStates.indexOf(state);
    const colour = colours[kind] ?? [1, 1, 1];
    const length = Math.hypot(bx - ax, by - ay) / pixel;
    const all = chosen || !many;
    if (all || (length >= kShortLine && seenLines.first(kind, ax, ay, bx, by))) {
      lines.add(ax, ay, bx, by, colour, 1, chosen ? 4 : 1.5, kPatterns[state]);
    }
    const [x, y] = [(ax + bx) / 2, (ay + by) / 2];
    const plain = state === "standing" && length >= kShortLine && length < kLongLine;
    if (!all && (plain || !seenMarks.first(kind, x, y, x, y))) continue;
    const shape = kShapes[state];
    const mark = chosen ? 14 : shape === Shape.Disc ? size - 2 : size;
    marks.add(x, y, 0, colour, 1, mark, shape);
  }
  return count;
}

export function fillSubmaps(
  lines: Lines,
  submaps: Submap[],
  palette: Palette,
  { box, pixel }: Sight,
): void {
  lines.clear();
  for (const { state, outline } of submaps) {
    const colour = colourOf(palette.submaps[state]);
    const pattern = state === "dropped" ? Pattern.Dashed : Pattern.Solid;
    const width = state === "open" ? 2 : 1;
    const corners = outline.length >> 1;
    const at = (k: number) => outline[k] ?? 0;
    for (let i = 0; i < corners; i++) {
      const j = (i + 1) % corners;
      const [ax, ay, bx, by] = [at(2 * i), at(2 * i + 1), at(2 * j), at(2 * j + 1)];
      if (Math.hypot(bx - ax, by - ay) < kSmallestOutline * pixel) continue;
      if (overlap(boxOf(ax, ay, bx, by), box)) {
        lines.add(ax, ay, bx, by, colour, 0.9, width, pattern);
      }
    }
  }
}
