import type { Camera } from "../camera.ts";
import { ignoreStretch } from "../edit_toml.ts";
import type { Point } from "../geometry.ts";
import type { Overlay } from "../overlay.ts";
import type { Track } from "../track.ts";
import { drawPlace, drawStretch } from "./draw.ts";
import type { MapTool } from "./map_tool.ts";
import { nearestVisit, type Visit, visitsNear } from "./visits.ts";

/** A click is of the path when it is that near, in pixels. */
const kReach = 24;

/** Two places on the path, chosen one after the other. */
export abstract class PlacesTool {
  /** Nodes; null until they are chosen. */
  readonly nodes: (number | null)[] = [null, null];
  /** Where the path passes near a chosen place. */
  readonly visits: Visit[][] = [[], []];
  /** Which of both the next click chooses; null when clicks choose none. */
  target: 0 | 1 | null = 0;
  /** What went wrong with the last click. */
  missed = false;

  constructor(
    readonly track: Track,
    readonly letters: readonly [string, string],
    protected readonly changed: () => void,
  ) {}

  abstract instruction(): string;

  get from(): number | null {
    return this.nodes[0] ?? null;
  }

  get to(): number | null {
    return this.nodes[1] ?? null;
  }

  choose(which: 0 | 1, node: number): void {
    if (!(node >= 0 && node < this.track.length)) return;
    this.nodes[which] = node;
    this.changed();
  }

  /** A node by its time, with the visits around it. */
  chooseAnew(which: 0 | 1, node: number): void {
    const at = this.track.pose(node);
    if (at !== null) this.visits[which] = visitsNear(this.track, at, 1);
    this.choose(which, node);
  }

  aim(which: 0 | 1 | null): void {
    this.target = which;
    this.changed();
  }

  click(at: Point, camera: Camera): void {
    const which = this.target;
    if (which === null) return;
    const visits = visitsNear(this.track, camera.toWorld(at), kReach / camera.scale);
    // Of a place that was passed twice the second one is most often meant as the other visit.
    const visit = nearestVisit(visits, which === 1 ? this.from : this.to);
    this.missed = visit === null;
    if (visit !== null) {
      this.visits[which] = visits;
      this.target = which === 0 && this.to === null ? 1 : null;
      this.choose(which, visit.node);
    } else this.changed();
  }

  takeBack(): boolean {
    const which = this.to !== null ? 1 : this.from !== null ? 0 : null;
    if (which === null) return false;
    this.nodes[which] = null;
    this.visits[which] = [];
    this.target = which;
    this.changed();
    return true;
  }

  drawPlaces(overlay: Overlay): void {
    const { drives } = overlay.palette;
    this.nodes.forEach((node, i) => {
      const pose = node === null ? null : this.track.pose(node);
      if (pose !== null) drawPlace(overlay, pose, this.letters[i] ?? "", drives[i] ?? "");
    });
  }

  protected get missedWords(): string {
    return this.missed ? "No path there. " : "";
  }
}

/** A stretch of the path whose scans are not used. */
export class StretchTool extends PlacesTool implements MapTool {
  constructor(track: Track, changed: () => void) {
    super(track, ["begin", "end"], changed);
  }

  instruction(): string {
    if (this.target === 0) return `${this.missedWords}Click where the stretch begins on the path.`;
    if (this.target === 1) return `${this.missedWords}Click where it ends.`;
    return "The scans of the marked stretch will not be used. Add it, or choose anew.";
  }

  doubleClick(): void {}

  grab(): null {
    return null;
  }

  key(): boolean {
    return false;
  }

  cursor(): string {
    return this.target === null ? "" : "crosshair";
  }

  draw(overlay: Overlay): void {
    if (this.from !== null && this.to !== null)
      drawStretch(overlay, this.track, this.from, this.to);
    this.drawPlaces(overlay);
  }

  problem(): string | null {
    if (this.from === null || this.to === null) return "Choose where the stretch begins and ends.";
    return null;
  }

  toml(): string {
    return ignoreStretch(this.from ?? 0, this.to ?? 0);
  }
}
