/** What the parts of the page share: the model, the choices, the map, and what they ask of each other. */
import { kPalettes, type Palette, type ThemeName } from "./colours.ts";
import type { Editor } from "./edit/editor.ts";
import type { Frames } from "./frames.ts";
import type { Closure } from "./json_messages.ts";
import type { MapView } from "./map_view.ts";
import type { Model, Part } from "./model.ts";
import type { Session } from "./session.ts";
import type { Settings } from "./settings.ts";

export class App {
  map!: MapView;
  editor!: Editor;
  theme: ThemeName = "dark";
  selected: number | null = null;
  private readonly choices: (() => void)[] = [];
  private readonly selections: (() => void)[] = [];
  private readonly announcer: (text: string) => void;

  constructor(
    readonly model: Model,
    readonly settings: Settings,
    readonly session: Session,
    readonly frames: Frames,
    announce: (text: string) => void,
  ) {
    this.announcer = announce;
  }

  get palette(): Palette {
    return kPalettes[this.theme];
  }

  /** Runs `show` before the next picture whenever one of the parts has changed. */
  watch(parts: Part[], show: () => void): void {
    this.model.on(parts, () => this.frames.request(show));
    this.frames.request(show);
  }

  /** The reader has chosen something: it is kept, and whoever shows it is told. */
  chosen(): void {
    this.settings.save();
    this.map.refill();
    for (const show of this.choices) this.frames.request(show);
  }

  onChosen(show: () => void): void {
    this.choices.push(show);
  }

  closure(id: number | null): Closure | null {
    if (id === null) return null;
    return this.model.closures.find((one) => one.id === id) ?? null;
  }

  select(id: number | null): void {
    if (id === this.selected) return;
    this.selected = id;
    this.map.scene.selected = id;
    this.map.scene.changed("closures");
    this.map.redraw();
    for (const show of this.selections) show();
  }

  onSelected(show: () => void): void {
    this.selections.push(show);
  }

  announce(text: string): void {
    this.announcer(text);
  }

  /** Where the run begins, which shown times count from. */
  get startTime(): number {
    const { model } = this;
    return model.start ?? (model.track.length > 0 ? (model.track.t[0] ?? 0) : 0);
  }

  goToClosure(closure: Closure): void {
    const a = this.model.track.pose(closure.from);
    const b = this.model.track.pose(closure.to);
    if (a === null || b === null) return;
    const span = Math.max(12, 2.5 * Math.hypot(b.x - a.x, b.y - a.y));
    this.map.goTo({ x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 }, span);
  }
}
