/** The list of edits of the made run, in memory: what a server of the contract answers. */
import { apply, kIdentity, type Pose } from "../src/geometry.ts";
import {
  BadRequest,
  type Done,
  Edited,
  kSentences,
  type Outline,
  parseEdits,
  perform,
  redrawn,
  Refusal,
  shiftOf,
  type Table,
} from "./edited.ts";
import { kVerdict } from "./messages.ts";
import type { DemoClosure, Node, Run } from "./run.ts";
import type { Tiles } from "./tiled_map.ts";

const kPictures = ["/loopstone/quality", "/loopstone/texture"];

export class DemoEdits {
  nodes: Node[];
  closures: DemoClosure[];
  tiles: Tiles;
  verdict: typeof kVerdict = kVerdict;
  /** Pictures on the map are of the frame without edits. */
  moved = false;
  /** What was written by the last save. */
  written = "";
  /** Texts that were sent, newest last. */
  readonly asked: string[] = [];
  /** The next request is answered by this instead. */
  refuseNext: BadRequest | null = null;
  private list: Table[] = [];
  private revision = 0;
  private drawn = 0;
  private saved = -1;
  private timer: NodeJS.Timeout | null = null;
  private told: object[] = [];
  private shift: object = {};

  constructor(
    readonly run: Run,
    private readonly drawDelay: number,
    private readonly publish: (topics: string[]) => void,
  ) {
    this.nodes = run.nodes;
    this.closures = run.closures;
    this.tiles = run.tiles();
    this.derive();
  }

  close(): void {
    if (this.timer !== null) clearTimeout(this.timer);
  }

  state(): object {
    const { revision, drawn, saved, told, shift } = this;
    const file = "out.edits.toml";
    const { verdict, sentence } = this.verdict;
    const command = `loopstone edit out --edits ${file} -o out2`;
    return { edits: told, revision, drawn, saved, file, command, verdict, sentence, shift };
  }

  /** What a POST to an address does. */
  post(path: string, body: unknown): object {
    const refused = this.refuseNext;
    this.refuseNext = null;
    if (refused !== null) throw refused;
    if (path === "/api/edits") this.add(body);
    else if (path === "/api/edits/undo") this.undo();
    else if (path === "/api/edits/save") this.save();
    else throw new BadRequest(404, "there is no such page");
    return this.state();
  }

  private add(body: unknown): void {
    const toml = (body as { toml?: unknown } | null)?.toml;
    if (typeof toml !== "string") throw new BadRequest(400, "toml is missing");
    this.asked.push(toml);
    const before = this.list;
    this.list = [...before, ...parseEdits(toml)];
    try {
      this.changed();
    } catch (error) {
      this.list = before;
      this.derive();
      throw error;
    }
  }

  private undo(): void {
    if (this.list.length === 0) throw new BadRequest(409, "there is no edit to undo");
    this.list = this.list.slice(0, -1);
    while (this.list[this.list.length - 1]?.kind === "as_edited")
      this.list = this.list.slice(0, -1);
    this.changed();
  }

  private save(): void {
    this.written = this.list.map(({ toml }) => toml).join("\n");
    this.saved = this.revision;
  }

  private changed(): void {
    const outlines = this.derive();
    this.revision++;
    this.publish(["/loopstone/trajectory", "/loopstone/closures", "/loopstone/verdict"]);
    if (this.timer !== null) clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.tiles = redrawn(this.run, outlines.frame, outlines.list);
      this.drawn = this.revision;
      this.publish(["/loopstone/tiles", "/loopstone/verdict", ...kPictures]);
    }, this.drawDelay);
  }

  /** All edits from the first on: undoing is to leave one out. */
  private derive(): { frame: Pose; list: Outline[] } {
    const map = new Edited(this.run);
    const first = map.poses;
    const reports = this.list.map((table) => this.report(table, map));
    this.told = reports.map((report, i) => {
      const corners = map.outlines[i]?.corners ?? [];
      const polygon = corners.map((p) => apply(map.frame, p)).flatMap(({ x, y }) => [x, y]);
      return { ...report, polygon };
    });
    const poses = map.poses;
    this.nodes = this.run.nodes.map((node, i) => ({ ...node, pose: poses[i] ?? node.pose }));
    this.closures = map.closures;
    this.shift = shiftOf(first, poses);
    const sentence = kSentences[map.verdict] ?? "";
    const places = kVerdict.places.map((place) => ({ ...place, ...apply(map.frame, place) }));
    this.verdict = { ...kVerdict, verdict: map.verdict, sentence, places };
    this.moved = map.frame !== kIdentity;
    return { frame: map.frame, list: map.outlines.filter((one) => one !== null) };
  }

  private report(table: Table, map: Edited): object {
    const before = map.poses;
    const verdict_before = map.verdict;
    map.outlines.push(null);
    const common = { kind: table.kind, toml: table.toml, verdict_before };
    let done: Done;
    let applied = true;
    try {
      done = perform(table, map);
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      applied = false;
      done = { told: error.message };
      if (error.closure !== null) done.closure = error.closure;
    }
    const { told, closure = null } = done;
    const shift = shiftOf(before, map.poses);
    return { ...common, applied, told, seconds: 0.031, verdict: map.verdict, shift, closure };
  }
}
