/** The map as the reader handles it: draws when something has changed, moves, picks, measures. */
import { Camera } from "./camera.ts";
import type { Palette } from "./colours.ts";
import type { MapTool } from "./edit/map_tool.ts";
import { distanceToSegment, isEmpty, type Point, wrapAngle } from "./geometry.ts";
import { type Drag, Gestures, type GestureTarget } from "./gestures.ts";
import type { Closure } from "./json_messages.ts";
import { Measure } from "./measure.ts";
import type { Model } from "./model.ts";
import { drawEdits } from "./edit/draw.ts";
import { Overlay } from "./overlay.ts";
import { Scene } from "./scene.ts";
import type { Settings } from "./settings.ts";

export type Mode = "fit" | "follow" | "free";

const kGlide = 260;
const kPickDistance = 12;
const kPanStep = 80;
const kTurnStep = Math.PI / 12;

interface Aim {
  x: number;
  y: number;
  scale: number;
  angle: number;
}

export interface MapListener {
  moved(): void;
  picked(closure: Closure | null): void;
  pointed(at: Point | null): void;
  measured(): void;
  contextRestored(): void;
}

export class MapView implements GestureTarget {
  readonly camera = new Camera();
  readonly measure = new Measure();
  /** What takes clicks, drags and keys for now. */
  tool: MapTool | null = null;
  scene: Scene;
  mode: Mode = "fit";
  pixelRatio = 1;
  frames = 0;
  /** Smoothed time that the processor spends on a picture [ms]. */
  frameTime = 0;
  /** Pixels at the bottom that something else covers. */
  covered = 0;
  private hoverAt: Point | null = null;
  private asked = false;
  private resized = true;
  private glide: { from: Aim; to: Aim; begin: number } | null = null;
  private readonly context: CanvasRenderingContext2D;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly overlay: HTMLCanvasElement,
    private readonly model: Model,
    private readonly settings: Settings,
    private palette: Palette,
    private readonly listener: MapListener,
  ) {
    const context = overlay.getContext("2d");
    if (context === null) throw new Error("This browser has no canvas.");
    this.context = context;
    this.scene = this.newScene();
    new Gestures(overlay, this);
    overlay.addEventListener("keydown", (event) => this.key(event));
    for (const type of ["focus", "blur"]) overlay.addEventListener(type, () => this.redraw());
    new ResizeObserver(() => this.resize()).observe(overlay);
    this.listenToModel();
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => {
      this.scene = this.newScene();
      listener.contextRestored();
      this.redraw();
    });
  }

  private newScene(): Scene {
    const { canvas, model, settings, palette } = this;
    const scene = new Scene(canvas, model, settings, palette, () => this.redraw());
    model.mapSink = scene.tiles;
    return scene;
  }

  private listenToModel(): void {
    const parts = ["trajectory", "closures", "submaps", "scan", "particles"] as const;
    const others = ["quality", "texture", "map", "pose", "edits", "reset"] as const;
    for (const part of [...parts, ...others]) {
      this.model.on([part], () => {
        this.scene.changed(part);
        this.redraw();
      });
    }
    this.model.on(["reset"], () => this.measure.clear());
  }

  setPalette(palette: Palette): void {
    this.palette = palette;
    this.scene.refill(palette);
    this.redraw();
  }

  refill(): void {
    this.scene.refill();
    this.redraw();
  }

  redraw(): void {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  /** Drawn at once: a picture of another size would be seen stretched until the next frame. */
  private resize(): void {
    this.resized = true;
    this.frame(performance.now());
  }

  private applySize(): void {
    this.resized = false;
    const ratio = Math.min(3, window.devicePixelRatio || 1);
    const { clientWidth, clientHeight } = this.overlay;
    this.pixelRatio = ratio;
    this.camera.width = Math.max(1, clientWidth);
    this.camera.height = Math.max(1, clientHeight);
    for (const canvas of [this.canvas, this.overlay]) {
      canvas.width = Math.max(1, Math.round(clientWidth * ratio));
      canvas.height = Math.max(1, Math.round(clientHeight * ratio));
    }
  }

  private frame(now: number): void {
    this.asked = false;
    const begin = performance.now();
    if (this.resized) this.applySize();
    this.steer(now);
    this.draw();
    const spent = performance.now() - begin;
    this.frames++;
    this.frameTime += (spent - this.frameTime) * (this.frames < 10 ? 0.5 : 0.05);
    this.listener.moved();
  }

  draw(): void {
    const { camera, settings, model, measure } = this;
    this.scene.draw(camera, this.pixelRatio);
    const overlay = new Overlay(this.context, camera, this.palette);
    overlay.begin(this.pixelRatio);
    if (settings.layers.edits && model.edits !== null) drawEdits(overlay, model.edits);
    if (settings.layers.robot && model.robot !== null) overlay.robot(model.robot);
    this.tool?.draw(overlay, this.hoverAt);
    if (measure.points.length > 0) overlay.measure(measure, this.hoverAt);
    if (this.overlay.matches(":focus-visible")) overlay.crosshair();
    overlay.scaleBar(16, 14);
  }

  /** The camera by the mode, or on its way to where it was sent. */
  private steer(now: number): void {
    const { camera, model } = this;
    if (this.glide !== null) {
      const { from, to, begin } = this.glide;
      const linear = Math.min(1, Math.max(0, (now - begin) / kGlide));
      const share = 1 - (1 - linear) ** 3;
      camera.x = from.x + (to.x - from.x) * share;
      camera.y = from.y + (to.y - from.y) * share;
      camera.scale = from.scale * (to.scale / from.scale) ** share;
      camera.angle = from.angle + wrapAngle(to.angle - from.angle) * share;
      if (linear >= 1) this.glide = null;
      else this.redraw();
      return;
    }
    if (this.mode === "fit") {
      const extent = this.scene.extent();
      if (!isEmpty(extent)) Object.assign(camera, camera.fitting(extent, this.tools, this.covered));
    } else if (this.mode === "follow" && model.robot !== null) {
      camera.x = model.robot.pose.x;
      camera.y = model.robot.pose.y;
    }
  }

  private glideTo(aim: Partial<Aim>): void {
    const { x, y, scale, angle } = this.camera;
    const from = { x, y, scale, angle };
    const to = { ...from, ...aim };
    const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (still) Object.assign(this.camera, to);
    else this.glide = { from, to, begin: performance.now() };
    this.redraw();
  }

  /** Pixels that the tools on the left take, where there is room to spare them. */
  private get tools(): number {
    return this.camera.width > 600 ? 44 : 0;
  }

  /** Something else wants the map. */
  endMeasuring(): void {
    if (!this.measure.active) return;
    this.measure.active = false;
    this.measure.clear();
    this.listener.measured();
  }

  setMode(mode: Mode): void {
    this.mode = mode;
    if (mode === "fit") {
      const extent = this.scene.extent();
      if (!isEmpty(extent)) this.glideTo(this.camera.fitting(extent, this.tools, this.covered));
    } else if (mode === "follow" && this.model.robot !== null) {
      const { x, y } = this.model.robot.pose;
      this.glideTo({ x, y, scale: Math.max(this.camera.scale, 25) });
    }
    this.redraw();
  }

  /** Shows a place, with about `span` metres across. */
  goTo(p: Point, span: number): void {
    const { width, height, angle } = this.camera;
    const scale = Math.min(width, height - this.covered) / Math.max(span, 0.5);
    const down = this.covered / 2 / scale;
    this.mode = "free";
    this.glideTo({ x: p.x - down * Math.sin(angle), y: p.y - down * Math.cos(angle), scale });
  }

  northUp(): void {
    this.glideTo({ angle: 0 });
  }

  turn(by: number): void {
    if (this.mode === "fit") this.mode = "free";
    this.glideTo({ angle: wrapAngle(this.camera.angle + by) });
  }

  // What pointers do.

  pan(dx: number, dy: number): void {
    this.glide = null;
    this.mode = "free";
    this.camera.pan(dx, dy);
    this.redraw();
  }

  zoom(at: Point, factor: number, turn: number): void {
    this.glide = null;
    if (this.mode === "fit") this.mode = "free";
    const middle = { x: this.camera.width / 2, y: this.camera.height / 2 };
    this.camera.zoomAt(this.mode === "follow" ? middle : at, factor, turn);
    this.redraw();
  }

  zoomMiddle(factor: number): void {
    this.zoom({ x: this.camera.width / 2, y: this.camera.height / 2 }, factor, 0);
  }

  grab(at: Point, turning: boolean): Drag | null {
    return this.tool?.grab(at, turning, this.camera) ?? null;
  }

  click(at: Point, byKey = false): void {
    if (this.tool !== null) {
      this.tool.click(at, this.camera, byKey);
      this.redraw();
      return;
    }
    if (this.measure.active) {
      this.measure.add(this.camera.toWorld(at));
      this.listener.measured();
      this.redraw();
      return;
    }
    this.listener.picked(this.closureAt(at, kPickDistance));
  }

  doubleClick(at: Point): void {
    if (this.tool !== null) {
      this.tool.doubleClick();
      this.redraw();
    } else if (this.measure.active) {
      this.measure.undo(); // the second of both clicks
      this.measure.finish();
      this.listener.measured();
      this.redraw();
    } else {
      this.zoom(at, 2, 0);
    }
  }

  hover(at: Point | null): void {
    this.hoverAt = at;
    this.listener.pointed(at === null ? null : this.camera.toWorld(at));
    this.overlay.style.cursor = this.cursorAt(at);
    if (this.measure.active || this.tool !== null) this.redraw();
  }

  private cursorAt(at: Point | null): string {
    if (this.tool !== null) return at === null ? "" : this.tool.cursor(at, this.camera);
    if (this.measure.active) return "crosshair";
    return at !== null && this.closureAt(at, 6) !== null ? "pointer" : "";
  }

  /** The closure whose line is nearest to a place of the screen, of those that are shown. */
  closureAt(at: Point, within: number): Closure | null {
    const { model, settings, camera } = this;
    if (!settings.layers.closures) return null;
    const p = camera.toWorld(at);
    let nearest = within / camera.scale;
    let found: Closure | null = null;
    for (const closure of model.closures) {
      if (!settings.closures[closure.state]) continue;
      const { from, to } = closure;
      const { track } = model;
      if (!(from < track.length && to < track.length)) continue;
      const a = { x: track.x(from), y: track.y(from) };
      const apart = distanceToSegment(p, a, { x: track.x(to), y: track.y(to) });
      if (apart < nearest) {
        nearest = apart;
        found = closure;
      }
    }
    return found;
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (this.tool?.key(event, this.camera)) {
      event.preventDefault();
      event.stopPropagation();
      this.redraw();
      return;
    }
    // With Shift, arrows are of time.
    if (event.shiftKey) return;
    const middle = { x: this.camera.width / 2, y: this.camera.height / 2 };
    const actions: Record<string, () => void> = {
      ArrowLeft: () => this.pan(kPanStep, 0),
      ArrowRight: () => this.pan(-kPanStep, 0),
      ArrowUp: () => this.pan(0, kPanStep),
      ArrowDown: () => this.pan(0, -kPanStep),
      Enter: () => {
        if (this.tool !== null || this.measure.active) this.click(middle, true);
        else this.pickNear(middle);
      },
      Backspace: () => {
        if (this.tool !== null) this.tool.takeBack();
        else this.measure.undo();
        this.listener.measured();
        this.redraw();
      },
    };
    const action = actions[event.key];
    if (action === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    action();
  }

  private pickNear(at: Point): void {
    this.listener.picked(this.closureAt(at, 60));
  }

  get turnStep(): number {
    return kTurnStep;
  }

  /** Map and what lies over it, as one picture. */
  picture(): HTMLCanvasElement {
    this.draw();
    const copy = document.createElement("canvas");
    copy.width = this.canvas.width;
    copy.height = this.canvas.height;
    const context = copy.getContext("2d");
    context?.drawImage(this.canvas, 0, 0);
    context?.drawImage(this.overlay, 0, 0);
    return copy;
  }

  /** Times of pictures drawn one after the other, each waited for [ms]. */
  measureFrames(count: number, between: () => void = () => undefined): number[] {
    return Array.from({ length: count }, () => {
      between();
      const begin = performance.now();
      this.draw();
      this.scene.finish();
      return performance.now() - begin;
    });
  }
}
