/** The map as WebGL draws it: layers are filled when the model has changed, drawn when asked. */
import type { Camera } from "./camera.ts";
import { type Palette, rampTable } from "./colours.ts";
import { fillClosures, fillPath, fillSubmaps, type Sight } from "./fills.ts";
import { type Box, emptyBox, include, isEmpty, roundLength } from "./geometry.ts";
import { PictureLayer } from "./gl/picture_layer.ts";
import { GlFailure, kPictureFragment, kQuadVertex, link, type Program } from "./gl/programs.ts";
import { Lines, Marks, Pattern, Shape, Shapes } from "./gl/shapes.ts";
import { TileLayer } from "./gl/tile_layer.ts";
import { View } from "./gl/view.ts";
import type { Model, Part } from "./model.ts";
import type { Settings } from "./settings.ts";

/** Buffers that are filled anew when something has changed. */
const kFills = ["path", "closures", "submaps", "scan", "particles"] as const;
type Fill = (typeof kFills)[number];
const kLeastExtent = 8;
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
  private readonly picture: Program;
  private readonly path: Lines;
  private readonly closureLines: Lines;
  private readonly closureMarks: Marks;
  private readonly submaps: Lines;
  private readonly gridLines: Lines;
  private readonly scan: Marks;
  private readonly particles: Marks;
  private readonly stale = new Set<Fill>();
  private ramp: Uint8Array;
  private vertexArray: WebGLVertexArrayObject | null;
  private sight: Sight = { box: emptyBox(), pixel: 1 };
  private closuresInSight = 0;
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
    const shapes = new Shapes(gl);
    this.picture = link(gl, kQuadVertex, kPictureFragment);
    this.tiles = new TileLayer(gl);
    this.quality = new PictureLayer(gl, redraw);
    this.texture = new PictureLayer(gl, redraw);
    this.path = new Lines(shapes);
    this.closureLines = new Lines(shapes);
    this.closureMarks = new Marks(shapes);
    this.submaps = new Lines(shapes);
    this.gridLines = new Lines(shapes);
    this.scan = new Marks(shapes);
    this.particles = new Marks(shapes);
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

  /** All that is worth seeing, and a room's width at least. */
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
    return isEmpty(box) ? box : atLeast(box, kLeastExtent);
  }

  draw(camera: Camera, pixelRatio: number): void {
    const { gl, settings, palette } = this;
    const { layers, opacity } = settings;
    this.fill(camera);
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
    if (layers.grid) this.drawGrid(view);
    if (layers.submaps) this.submaps.draw(view);
    if (layers.path) this.path.draw(view);
    if (layers.closures) {
      this.closureLines.draw(view);
      this.closureMarks.draw(view);
    }
    if (layers.particles) this.particles.draw(view);
    if (layers.scan) this.scan.draw(view);
  }

  /** Waits until the card is done; for measuring. */
  finish(): void {
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  /** What was filled holds while the camera sees no more, and nothing much finer or coarser. */
  private look(camera: Camera): Sight {
    const pixel = 1 / camera.scale;
    const seen = camera.seen();
    const { box } = this.sight;
    const ratio = pixel / this.sight.pixel;
    const inside =
      seen.left >= box.left &&
      seen.right <= box.right &&
      seen.bottom >= box.bottom &&
      seen.top <= box.top;
    if (!inside || ratio > 1.25 || ratio < 0.8) {
      const aside = seen.right - seen.left;
      const up = seen.top - seen.bottom;
      const wide = {
        left: seen.left - aside / 2,
        right: seen.right + aside / 2,
        bottom: seen.bottom - up / 2,
        top: seen.top + up / 2,
      };
      this.sight = { box: wide, pixel };
      for (const fill of ["path", "closures", "submaps"] as const) this.stale.add(fill);
    }
    return this.sight;
  }

  private fill(camera: Camera): void {
    const { model, settings, palette, selected } = this;
    const sight = this.look(camera);
    const { track, closures } = model;
    const fills = {
      path: () => fillPath(this.path, track, settings.pathColour, this.ramp, palette, sight),
      closures: () => {
        const what = { closures, track, shown: settings.closures, selected, palette };
        this.closuresInSight = fillClosures(this.closureLines, this.closureMarks, what, sight);
      },
      submaps: () => fillSubmaps(this.submaps, model.submaps, palette, sight),
      scan: () => this.fillScan(),
      particles: () => this.fillParticles(),
    };
    for (const name of this.stale) fills[name]();
    this.stale.clear();
  }

  private fillScan(): void {
    const { scan, palette, model } = this;
    scan.clear();
    for (const { points, length } of model.scans.values()) {
      for (let i = 0; i + 1 < length; i += 2) {
        scan.add(points[i] ?? 0, points[i + 1] ?? 0, 0, palette.scan, 1, 3.5, Shape.Disc);
      }
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
    gridLines.draw(view);
  }

  /** For tests and the help: what was handed to the card. */
  counts(): Record<string, number> {
    return {
      blocks: this.tiles.blockCount,
      tiles: this.tiles.tiles.size,
      path: this.path.count,
      closures: this.closuresInSight,
      closureLines: this.closureLines.count,
      closureMarks: this.closureMarks.count,
      submapLines: this.submaps.count,
      scan: this.scan.count,
      particles: this.particles.count,
    };
  }
}

function atLeast(box: Box, side: number): Box {
  const aside = Math.max(0, side - (box.right - box.left)) / 2;
  const up = Math.max(0, side - (box.top - box.bottom)) / 2;
  const { left, right, bottom, top } = box;
  return { left: left - aside, right: right + aside, bottom: bottom - up, top: top + up };
}

/** Grid lines are at least 60 pixels apart. */
export function gridStep(scale: number): number {
  const least = 60 / scale;
  const round = roundLength(least);
  if (round >= least * 0.999) return round;
  return roundLength(round * 2.5);
}
