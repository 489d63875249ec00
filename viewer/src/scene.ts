/** The map as WebGL draws it: layers are filled when the model has changed, drawn when asked. */
import type { Camera } from "./camera.ts";
import { type Colour, colourOf, type Palette, rampTable } from "./colours.ts";
import { type Box, emptyBox, include, isEmpty, roundLength } from "./geometry.ts";
import { PictureLayer } from "./gl/picture_layer.ts";
import { GlFailure, kPictureFragment, kQuadVertex, link, type Program } from "./gl/programs.ts";
import { Lines, Marks, Pattern, Polyline, Shape, ShapePrograms } from "./gl/shapes.ts";
import { TileLayer } from "./gl/tile_layer.ts";
import { View } from "./gl/view.ts";
import type { ClosureState } from "./json_messages.ts";
import type { Model, Part } from "./model.ts";
import type { Settings } from "./settings.ts";

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
/** Buffers that are filled anew when something has changed. */
const kFills = ["path", "closures", "submaps", "scan", "particles"] as const;
type Fill = (typeof kFills)[number];
const kFillsOf: Partial<Record<Part, Fill[]>> = {
  trajectory: ["path", "closures"],
  closures: ["closures"],
  submaps: ["submaps"],
  scan: ["scan"],
  particles: ["particles"],
};

export class Scene {
  readonly tiles: TileLayer;
  readonly quality: PictureLayer;
  readonly texture: PictureLayer;
  private readonly gl: WebGL2RenderingContext;
  private readonly programs: ShapePrograms;
  private readonly picture: Program;
  private readonly path: Polyline;
  private readonly closureLines: Lines;
  private readonly closureMarks: Marks;
  private readonly submaps: Lines;
  private readonly gridLines: Lines;
  private readonly scan: Marks;
  private readonly particles: Marks;
  private readonly stale = new Set<Fill>();
  private ramp: Uint8Array;
  private vertexArray: WebGLVertexArrayObject | null;
  /** Least and largest of what colours the path. */
  pathRange: [number, number] = [0, 0];
  selected: number | null = null;

  constructor(
    canvas: HTMLCanvasElement,
    private readonly model: Model,
    private readonly settings: Settings,
    private palette: Palette,
    redraw: () => void,
  ) {
    const gl = canvas.getContext("webgl2", {
      alpha: false,
      antialias: false,
      depth: false,
      stencil: false,
      powerPreference: "high-performance",
    });
    if (gl === null) throw new GlFailure("This browser has no WebGL 2, which draws the map.");
    this.gl = gl;
    this.vertexArray = gl.createVertexArray();
    this.programs = new ShapePrograms(gl);
    this.picture = link(gl, kQuadVertex, kPictureFragment);
    this.tiles = new TileLayer(gl);
    this.quality = new PictureLayer(gl, redraw);
    this.texture = new PictureLayer(gl, redraw);
    this.path = new Polyline(gl);
    this.closureLines = new Lines(gl);
    this.closureMarks = new Marks(gl);
    this.submaps = new Lines(gl);
    this.gridLines = new Lines(gl);
    this.scan = new Marks(gl);
    this.particles = new Marks(gl);
    this.ramp = rampTable(palette.ramp);
    this.changed("reset");
  }

  /** A part of the model has changed. */
  changed(part: Part): void {
    const fills = part === "reset" ? kFills : (kFillsOf[part] ?? []);
    for (const fill of fills) this.stale.add(fill);
    if (part === "quality" || part === "reset") this.quality.show(this.model.quality);
    if (part === "texture" || part === "reset") this.texture.show(this.model.texture);
  }

  /** After a choice of the reader: all is filled anew. */
  refill(palette = this.palette): void {
    this.palette = palette;
    this.ramp = rampTable(palette.ramp);
    for (const fill of kFills) this.stale.add(fill);
  }

  /** All that is worth seeing. */
  extent(): Box {
    const box = emptyBox();
    const { track, robot } = this.model;
    const boxes = [this.tiles.box];
    if (this.texture.ready) boxes.push(this.texture.box);
    for (const one of boxes) {
      if (isEmpty(one)) continue;
      include(box, one.left, one.bottom);
      include(box, one.right, one.top);
    }
    if (isEmpty(box)) {
      for (let i = 0; i < track.length; i++) include(box, track.x(i), track.y(i));
      if (robot !== null) include(box, robot.pose.x, robot.pose.y);
    }
    return box;
  }

  draw(camera: Camera, pixelRatio: number): void {
    const { gl, settings, palette } = this;
    const { layers, opacity } = settings;
    this.fill();
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.clearColor(palette.unknown[0], palette.unknown[1], palette.unknown[2], 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.bindVertexArray(this.vertexArray);
    const view = new View(gl, camera, palette, pixelRatio);
    if (layers.map) this.tiles.draw(view, opacity.map);
    if (layers.texture) this.texture.draw(view, this.picture, opacity.texture);
    if (layers.quality) this.quality.draw(view, this.picture, opacity.quality);
    const { line, mark } = this.programs;
    if (layers.grid) this.drawGrid(view);
    if (layers.submaps) this.submaps.draw(view, line);
    if (layers.path) this.path.draw(view, line, 2);
    if (layers.closures) {
      this.closureLines.draw(view, line);
      this.closureMarks.draw(view, mark);
    }
    if (layers.particles) this.particles.draw(view, mark);
    if (layers.scan) this.scan.draw(view, mark);
  }

  /** Waits until the card is done; for measuring. */
  finish(): void {
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  private fill(): void {
    const fills = {
      path: () => this.fillPath(),
      closures: () => this.fillClosures(),
      submaps: () => this.fillSubmaps(),
      scan: () => this.fillScan(),
      particles: () => this.fillParticles(),
    };
    for (const name of this.stale) fills[name]();
    this.stale.clear();
  }

  private fillPath(): void {
    const { path, ramp, palette, settings } = this;
    const { track } = this.model;
    const by = settings.pathColour;
    const values = by === "time" ? track.t : track.sigma;
    let low = Infinity;
    let high = -Infinity;
    for (let i = 0; i < track.length; i++) {
      const value = values[i] ?? 0;
      if (value < low) low = value;
      if (value > high) high = value;
    }
    if (by === "uncertainty") low = 0;
    this.pathRange = track.length > 0 ? [low, high] : [0, 0];
    const drives = palette.drives.map(colourOf);
    path.clear();
    for (let i = 0; i < track.length; i++) {
      const joined = i > 0 && track.drives[i] === track.drives[i - 1];
      if (by === "drive") {
        const [red, green, blue] = drives[(track.drives[i] ?? 0) % drives.length] ?? [0, 0, 0];
        path.add(track.x(i), track.y(i), red * 255, green * 255, blue * 255, joined);
        continue;
      }
      const share = high > low ? ((values[i] ?? 0) - low) / (high - low) : 0;
      const at = 3 * Math.round(255 * Math.min(1, Math.max(0, share)));
      path.add(track.x(i), track.y(i), ramp[at] ?? 0, ramp[at + 1] ?? 0, ramp[at + 2] ?? 0, joined);
    }
  }

  private fillClosures(): void {
    const { closureLines, closureMarks, palette, settings, model } = this;
    const { track } = model;
    closureLines.clear();
    closureMarks.clear();
    // Not too many marks: on 5,000 closures they would hide the map.
    const size = model.closures.length > 1000 ? 6 : 8;
    const colours = Object.fromEntries(
      Object.entries(palette.closures).map(([state, hex]) => [state, colourOf(hex)]),
    ) as Record<ClosureState, Colour>;
    for (const { id, from, to, state } of model.closures) {
      if (!(from < track.length && to < track.length)) continue;
      const selected = id === this.selected;
      if (!settings.closures[state] && !selected) continue;
      const [ax, ay, bx, by] = [track.x(from), track.y(from), track.x(to), track.y(to)];
      const colour = colours[state];
      closureLines.add(ax, ay, bx, by, colour, 1, selected ? 4 : 1.5, kPatterns[state]);
      const shape = kShapes[state];
      const mark = selected ? 14 : shape === Shape.Disc ? size - 2 : size;
      closureMarks.add((ax + bx) / 2, (ay + by) / 2, 0, colour, 1, mark, shape);
    }
  }

  private fillSubmaps(): void {
    const { submaps, palette, model } = this;
    submaps.clear();
    for (const { state, outline } of model.submaps) {
      const colour = colourOf(palette.submaps[state]);
      const pattern = state === "dropped" ? Pattern.Dashed : Pattern.Solid;
      const width = state === "open" ? 2 : 1;
      const corners = outline.length >> 1;
      for (let i = 0; i < corners; i++) {
        const j = (i + 1) % corners;
        const at = (k: number) => outline[k] ?? 0;
        const [ax, ay, bx, by] = [at(2 * i), at(2 * i + 1), at(2 * j), at(2 * j + 1)];
        submaps.add(ax, ay, bx, by, colour, 0.9, width, pattern);
      }
    }
  }

  private fillScan(): void {
    const { scan, palette, model } = this;
    scan.clear();
    for (let i = 0; i + 1 < model.scanLength; i += 2) {
      const [x = 0, y = 0] = [model.scan[i], model.scan[i + 1]];
      scan.add(x, y, 0, palette.scan, 1, 3.5, Shape.Disc);
    }
  }

  private fillParticles(): void {
    const { particles, palette, model } = this;
    const poses = model.particles;
    const alpha = poses.length > 3 * 2000 ? 0.45 : 0.8;
    particles.clear();
    for (let i = 0; i + 2 < poses.length; i += 3) {
      const [x = 0, y = 0, yaw = 0] = [poses[i], poses[i + 1], poses[i + 2]];
      particles.add(x, y, yaw, palette.particles, alpha, 9, Shape.Arrow);
    }
  }

  private drawGrid(view: View): void {
    const { gridLines, palette } = this;
    const { seen, camera } = view;
    const step = gridStep(camera.scale);
    gridLines.clear();
    const lines = (from: number, to: number, add: (at: number, axis: boolean) => void) => {
      for (let i = Math.ceil(from / step); i <= Math.floor(to / step); i++) add(i * step, i === 0);
    };
    const alpha = (axis: boolean) => (axis ? 0.9 : 0.4);
    lines(seen.left, seen.right, (x, axis) =>
      gridLines.add(x, seen.bottom, x, seen.top, palette.grid, alpha(axis), 1, Pattern.Solid),
    );
    lines(seen.bottom, seen.top, (y, axis) =>
      gridLines.add(seen.left, y, seen.right, y, palette.grid, alpha(axis), 1, Pattern.Solid),
    );
    gridLines.draw(view, this.programs.line);
  }

  /** For tests and the help: what was handed to the card. */
  counts(): Record<string, number> {
    return {
      blocks: this.tiles.blockCount,
      tiles: this.tiles.tiles.size,
      path: this.path.count,
      closures: this.closureLines.count,
      submapLines: this.submaps.count,
      scan: this.scan.count,
      particles: this.particles.count,
    };
  }
}

/** Grid lines are at least 60 pixels apart. */
export function gridStep(scale: number): number {
  const least = 60 / scale;
  const round = roundLength(least);
  if (round >= least * 0.999) return round;
  return roundLength(round * 2.5);
}
