import type { Camera } from "../camera.ts";
import { addClosure } from "../edit_toml.ts";
import {
  apply,
  compose,
  distance,
  inverse,
  type Point,
  type Pose,
  wrapAngle,
} from "../geometry.ts";
import type { Drag } from "../gestures.ts";
import type { Overlay } from "../overlay.ts";
import type { Track } from "../track.ts";
import { drawHeading, drawScan } from "./draw.ts";
import { kStep, kTurn, type MapTool } from "./map_tool.ts";
import { numberIn } from "./polygon_tool.ts";
import { PlacesTool } from "./stretch_tool.ts";

const kGrabReach = 14;
/** Of the arrows of both robots; the second one's tip turns its scan. */
const kArrow = 48;

/** A scan of a node, or that there is none. */
export type ScanPoints = number[] | null;

/** Two places that are one: their scans on each other, the second where the reader moves it. */
export class ClosureTool extends PlacesTool implements MapTool {
  withoutGuess = false;
  force = false;
  halfWindow = "";
  /** Of both, in the robot's frame; undefined until they came. */
  readonly scans: [ScanPoints | undefined, ScanPoints | undefined] = [undefined, undefined];
  /** from_T_to as the reader has moved it; null while it lies where the map has it. */
  private moved: Pose | null = null;
  private shownNodes = "";

  constructor(
    track: Track,
    changed: () => void,
    private readonly fetchScan: (node: number) => Promise<ScanPoints>,
    /** A scan has come. */
    private readonly arrived: () => void,
    /** Both places are there: whoever shows the map may go there. */
    private readonly placed: (a: Pose, b: Pose) => void,
  ) {
    super(track, ["1", "2"], changed);
  }

  instruction(): string {
    const { missedWords } = this;
    if (this.target === 0) return `${missedWords}Click the first place on the path.`;
    if (this.target === 1) return `${missedWords}Click the second place, of the other visit.`;
    if (this.withoutGuess) return "It is searched for about where the map has it now.";
    return "Drag the second scan (crosses) onto the first. Its arrow, or Shift, turns it.";
  }

  override choose(which: 0 | 1, node: number): void {
    super.choose(which, node);
    this.update();
  }

  override takeBack(): boolean {
    if (this.moved !== null) {
      this.moved = null;
      this.changed();
      return true;
    }
    const taken = super.takeBack();
    this.update();
    return taken;
  }

  /** After either place has changed: its scan is asked for, and the guess begins anew. */
  private update(): void {
    const key = this.nodes.join(" ");
    if (key === this.shownNodes) return;
    this.shownNodes = key;
    this.moved = null;
    this.nodes.forEach((node, i) => void this.load(node, i as 0 | 1));
    const a = this.placeOf(0);
    const b = this.placeOf(1);
    if (a !== null && b !== null) this.placed(a, b);
    this.changed();
  }

  private async load(node: number | null, which: 0 | 1): Promise<void> {
    this.scans[which] = undefined;
    if (node === null) return;
    const points = await this.fetchScan(node);
    if (this.nodes[which] !== node) return;
    this.scans[which] = points;
    this.arrived();
  }

  private placeOf(which: 0 | 1): Pose | null {
    const node = this.nodes[which] ?? null;
    return node === null ? null : this.track.pose(node);
  }

  /** Where the map has `to` now, seen from `from`. */
  get onMap(): Pose | null {
    const [a, b] = [this.placeOf(0), this.placeOf(1)];
    return a !== null && b !== null ? compose(inverse(a), b) : null;
  }

  /** Where the second scan is drawn, seen from the first. */
  get guess(): Pose | null {
    return this.withoutGuess ? this.onMap : (this.moved ?? this.onMap);
  }

  get isMoved(): boolean {
    return this.moved !== null;
  }

  setGuess(guess: Pose): void {
    if (!Number.isFinite(guess.x + guess.y + guess.yaw)) return;
    this.moved = { ...guess, yaw: wrapAngle(guess.yaw) };
    this.changed();
  }

  reset(): void {
    this.moved = null;
    this.changed();
  }

  /** The second place in the map's frame as the guess has it. */
  private get second(): Pose | null {
    const a = this.placeOf(0);
    const { guess } = this;
    return a !== null && guess !== null ? compose(a, guess) : null;
  }

  private setSecond(map_T_to: Pose): void {
    const a = this.placeOf(0);
    if (a !== null) this.setGuess(compose(inverse(a), map_T_to));
  }

  private get placing(): boolean {
    return this.target === null && !this.withoutGuess && this.second !== null;
  }

  private near(at: Point, camera: Camera): boolean {
    const { second } = this;
    if (second === null) return false;
    if (distance(camera.toScreen(second), at) <= 2 * kGrabReach) return true;
    const points = this.scans[1] ?? [];
    for (let i = 0; i + 1 < points.length; i += 2) {
      const p = apply(second, { x: points[i] ?? 0, y: points[i + 1] ?? 0 });
      if (distance(camera.toScreen(p), at) <= kGrabReach) return true;
    }
    return false;
  }

  private atTip(at: Point, camera: Camera): boolean {
    const { second } = this;
    if (second === null) return false;
    const { x, y } = camera.toScreen(second);
    const angle = second.yaw + camera.angle;
    const tip = { x: x + kArrow * Math.cos(angle), y: y - kArrow * Math.sin(angle) };
    return distance(tip, at) <= kGrabReach;
  }

  grab(at: Point, withShift: boolean, camera: Camera): Drag | null {
    const begin = this.second;
    const turning = withShift || this.atTip(at, camera);
    if (!this.placing || begin === null || !(turning || this.near(at, camera))) return null;
    const start = camera.toWorld(at);
    const before = this.moved;
    const angle = (p: Point) => Math.atan2(p.y - begin.y, p.x - begin.x);
    return {
      move: (now) => {
        const p = camera.toWorld(now);
        if (turning) this.setSecond({ ...begin, yaw: begin.yaw + angle(p) - angle(start) });
        else this.setSecond({ ...begin, x: begin.x + p.x - start.x, y: begin.y + p.y - start.y });
      },
      end: (meant) => {
        if (meant) return;
        this.moved = before;
        this.changed();
      },
    };
  }

  doubleClick(): void {}

  key(event: KeyboardEvent, camera: Camera): boolean {
    const { second } = this;
    if (!this.placing || second === null) return false;
    const share = event.shiftKey ? 0.1 : 1;
    // Along the screen's axes: right is right however the view is turned.
    const c = Math.cos(camera.angle) * kStep * share;
    const s = Math.sin(camera.angle) * kStep * share;
    const steps: Record<string, Pose> = {
      ArrowRight: { x: c, y: -s, yaw: 0 },
      ArrowLeft: { x: -c, y: s, yaw: 0 },
      ArrowUp: { x: s, y: c, yaw: 0 },
      ArrowDown: { x: -s, y: -c, yaw: 0 },
      "[": { x: 0, y: 0, yaw: kTurn },
      "]": { x: 0, y: 0, yaw: -kTurn },
      "{": { x: 0, y: 0, yaw: kTurn / 10 },
      "}": { x: 0, y: 0, yaw: -kTurn / 10 },
    };
    const step = steps[event.key];
    if (step === undefined) return false;
    this.setSecond({ x: second.x + step.x, y: second.y + step.y, yaw: second.yaw + step.yaw });
    return true;
  }

  cursor(at: Point, camera: Camera): string {
    if (this.target !== null) return "crosshair";
    if (!this.placing) return "";
    return this.atTip(at, camera) ? "grab" : this.near(at, camera) ? "move" : "";
  }

  draw(overlay: Overlay): void {
    const { drives } = overlay.palette;
    const [first = "", other = ""] = drives;
    const a = this.placeOf(0);
    const { second } = this;
    if (a !== null) {
      drawScan(overlay, this.scans[0] ?? [], a, first, false);
      drawHeading(overlay, a, kArrow, first);
    }
    if (second !== null) {
      drawScan(overlay, this.scans[1] ?? [], second, other, true);
      drawHeading(overlay, second, kArrow, other);
    }
    this.drawPlaces(overlay);
  }

  problem(): string | null {
    const { from, to } = this;
    if (from === null || to === null) return "Choose both places.";
    if (from === to) return "Both places are the same node.";
    if (this.halfWindow.trim() !== "") {
      const half = numberIn(this.halfWindow);
      if (!(half >= 0.05 && half <= 30)) return "It is searched within 0.05 to 30 m.";
    }
    return null;
  }

  toml(): string {
    const halfWindow = this.halfWindow.trim() === "" ? null : numberIn(this.halfWindow);
    const guess = this.withoutGuess ? null : this.guess;
    const { force } = this;
    return addClosure({ from: this.from ?? 0, to: this.to ?? 0, guess, halfWindow, force });
  }
}
