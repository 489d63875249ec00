/** A hand on the map: the tool that is in use, and what the server said last. */
import type { App } from "../app.ts";
import { type EditClient, type Outcome } from "../edit_client.ts";
import { deleteClosure, kPolygonKinds, type PolygonKind, straighten } from "../edit_toml.ts";
import type { Edit } from "../edits.ts";
import { isObject, numbersOf, parseObject } from "../json.ts";
import type { Closure } from "../json_messages.ts";
import { distance, type Pose } from "../geometry.ts";
import { ClosureTool, type ScanPoints } from "./closure_tool.ts";
import type { MapTool } from "./map_tool.ts";
import { OriginTool } from "./origin_tool.ts";
import { PolygonTool } from "./polygon_tool.ts";
import { StretchTool } from "./stretch_tool.ts";

export const kToolKinds = ["add_closure", "ignore", ...kPolygonKinds, "origin"] as const;
export type ToolKind = (typeof kToolKinds)[number];

export interface EditTool extends MapTool {
  /** Why it can't be sent yet; null when it can. */
  problem(): string | null;
  toml(): string;
}

export interface Message {
  text: string;
  bad: boolean;
}

/** Places are told by nodes, which mean the same on every map; all else by where it lies in sight. */
const kOnMap: Record<ToolKind, boolean> = {
  add_closure: true,
  ignore: false,
  crop: true,
  erase: true,
  keep_out: true,
  speed: true,
  origin: true,
};

const kNotDrawn =
  "The map in sight is not drawn with the last edit yet. Wait a moment, and look where this lies.";

export class Editor {
  tool: EditTool | null = null;
  kind: ToolKind | null = null;
  message: Message = { text: "", bad: false };
  /** The last edit where it was refused, so that what it was told by can be changed. */
  refused: Edit | null = null;
  private begunAt = 0;
  private wasDrawn = true;
  private readonly listeners: (() => void)[] = [];

  constructor(
    private readonly app: App,
    readonly client: EditClient,
  ) {
    app.model.on(["edits"], () => this.stateChanged());
    app.model.on(["reset"], () => this.cancel());
    app.model.on(["about"], () => {
      if (!client.allowed) this.cancel();
    });
  }

  get allowed(): boolean {
    return this.client.allowed;
  }

  on(listener: () => void): void {
    this.listeners.push(() => this.app.frames.request(listener));
  }

  /** The tool, the message or what is being done has changed. */
  readonly changed = (): void => {
    this.app.map.redraw();
    for (const listener of this.listeners) listener();
  };

  /** The reader has done something with the tool: what was wrong before is no longer told. */
  readonly toolChanged = (): void => {
    if (this.message.bad) this.message = { text: "", bad: false };
    this.changed();
  };

  say(text: string, bad = false): void {
    this.message = { text, bad };
    if (text !== "") this.app.announce(text);
    this.changed();
  }

  begin(kind: ToolKind): void {
    if (!this.allowed) return;
    const { map } = this.app;
    map.endMeasuring();
    this.kind = kind;
    this.tool = map.tool = this.make(kind);
    this.begunAt = this.app.model.edits?.revision ?? 0;
    this.refused = null;
    this.say("");
  }

  private make(kind: ToolKind): EditTool {
    const { track } = this.app.model;
    if (kind === "ignore") return new StretchTool(track, this.toolChanged);
    if (kind === "origin") return new OriginTool(this.toolChanged);
    if (kind === "add_closure") {
      const fetchScan = (node: number) => this.fetchScan(node);
      const lookAt = (a: Pose, b: Pose) => this.lookAt(a, b);
      return new ClosureTool(track, this.toolChanged, fetchScan, this.changed, lookAt);
    }
    return new PolygonTool(kind satisfies PolygonKind, this.toolChanged);
  }

  private lookAt(a: Pose, b: Pose): void {
    const span = Math.max(14, 2 * distance(a, b));
    this.app.map.goTo({ x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 }, span);
  }

  /** Of a node, in the robot's frame; null where there is none. */
  private async fetchScan(node: number): Promise<ScanPoints> {
    try {
      const answer = await fetch(this.app.session.api(`api/nodes/${node}/scan`));
      const json = answer.ok ? parseObject(await answer.text()) : null;
      return isObject(json) ? numbersOf(json["points"]) : null;
    } catch {
      return null;
    }
  }

  /** Puts the tool away; what was drawn with it goes. */
  cancel(): void {
    if (this.tool === null) return;
    this.end();
    this.say("");
  }

  private end(): void {
    this.tool = this.kind = this.refused = null;
    this.app.map.tool = null;
    this.app.map.hover(null);
  }

  takeBack(): boolean {
    return this.tool?.takeBack() ?? false;
  }

  /** What the tool has goes to the server; it stays in hand when that fails or is refused. */
  async send(): Promise<boolean> {
    const { tool, kind, app } = this;
    if (tool === null || kind === null) return false;
    const { edits } = app.model;
    const lies = kind !== "add_closure" && kOnMap[kind];
    const late = lies && edits !== null && edits.drawn < edits.revision;
    const problem = tool.problem() ?? (late ? kNotDrawn : null);
    if (problem !== null) {
      this.say(problem, true);
      return false;
    }
    const outcome = await this.client.add(tool.toml(), kOnMap[kind], "Doing the edit …");
    const done = this.tell(outcome);
    if (outcome.done) this.begunAt = outcome.state.revision;
    if (done && this.tool === tool) {
      this.end();
      if (kind === "origin" || kind === "crop") app.map.setMode("fit");
    }
    this.changed();
    return done;
  }

  async straighten(): Promise<void> {
    const outcome = await this.client.add(straighten(), false, "Straightening …");
    if (this.tell(outcome)) this.app.map.setMode("fit");
  }

  async deleteClosure(closure: Closure | null): Promise<void> {
    if (!this.allowed || closure === null) return;
    if (closure.state !== "standing") {
      this.say(`Closure ${closure.id} does not stand: there is nothing to delete.`, true);
      return;
    }
    const toml = deleteClosure(closure.from, closure.to);
    this.tell(await this.client.add(toml, false, `Deleting closure ${closure.id} …`));
  }

  async undo(): Promise<void> {
    if (!this.allowed) return;
    const before = this.app.model.edits?.edits ?? [];
    if (before.length === 0) {
      this.say("There is nothing to undo.", true);
      return;
    }
    const outcome = await this.client.undo();
    if (!outcome.done) this.say(outcome.why, true);
    else {
      this.refused = null;
      this.say("Undone.");
      const turned = before.some(({ kind }) => kind === "origin" || kind === "straighten");
      if (turned) this.app.map.setMode("fit");
    }
  }

  async save(): Promise<void> {
    const outcome = await this.client.save();
    if (outcome.done) this.say(`Saved as ${outcome.state.file}.`);
    else this.say(outcome.why, true);
  }

  /** Whether the last edit was done; what it did, or why not, is told. */
  private tell(outcome: Outcome): boolean {
    if (!outcome.done) {
      this.say(outcome.why, true);
      return false;
    }
    const last = outcome.state.edits.at(-1);
    if (last === undefined) return false;
    this.refused = last.applied ? null : last;
    const told = last.told.replace(/\.?$/, ".");
    this.say(last.applied ? `Done: ${told}` : `Refused: ${told}`, !last.applied);
    return last.applied;
  }

  private stateChanged(): void {
    const { edits } = this.app.model;
    const drawn = edits === null || edits.drawn >= edits.revision;
    if (drawn && !this.wasDrawn) this.app.announce("The map is drawn with the last edit.");
    this.wasDrawn = drawn;
    const busy = this.client.busy !== "";
    if (edits !== null && !busy && this.tool !== null && edits.revision !== this.begunAt) {
      this.begunAt = edits.revision;
      this.say("The map has changed since this was begun: look where it lies now.", true);
    }
    this.changed();
  }
}
