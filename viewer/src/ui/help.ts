import type { App } from "../app.ts";
import { kClosureStates } from "../json_messages.ts";
import { kClosureWords, trackingWords } from "../words.ts";
import { h, iconButton, need, swatch } from "./dom.ts";

type Section = [string, [string, string][]];

/** Where the map may be edited. */
const kEditKeys: Section = [
  "Editing",
  [
    ["5", "the edits, and what can be done"],
    ["Del", "delete the chosen closure"],
    ["Ctrl+Z", "take back the last point; without any undo the last edit"],
    ["Enter", "a point in the middle; the first one, or the last again, closes"],
    ["Backspace", "take back the last point"],
    ["← ↑ → ↓", "move the second scan, in small steps with Shift"],
    ["[ ]", "turn the second scan, or the heading of the origin"],
    ["Esc", "put the tool away"],
  ],
];

const kKeys: Section[] = [
  [
    "Time",
    [
      ["Space", "play, pause"],
      ["← →", "a key scan back, on (the map not being in focus)"],
      [", .", "the same, wherever the focus is"],
      ["Shift ← →", "ten seconds back, on"],
      ["< >", "slower, faster"],
      ["Home End", "on the slider: first, last"],
    ],
  ],
  [
    "Map",
    [
      ["F", "fit all of it"],
      ["R", "follow the robot"],
      ["← ↑ → ↓", "move (the map being in focus)"],
      ["+ -", "zoom"],
      ["[ ]", "turn"],
      ["0", "north up again"],
      ["Enter", "choose the closure in the middle"],
      ["M", "measure; Enter or click sets a point, Backspace takes it back, Esc ends"],
      ["G", "grid"],
    ],
  ],
  [
    "Panels",
    [
      ["1 2 3 4", "overview, closures, layers, plots"],
      ["N B", "next closure, the one before"],
      ["Z", "zoom to the closure"],
      ["V", "its scans as measured, as the graph has it"],
      ["T", "theme: as the system, dark, light"],
      ["P", "save a picture of the map"],
      ["?", "this help"],
      ["Esc", "close, end"],
    ],
  ],
];

export class Help {
  private readonly dialog = need<HTMLDialogElement>("help");

  constructor(private readonly app: App) {
    this.dialog.addEventListener("click", (event) => {
      if (event.target === this.dialog) this.dialog.close();
    });
  }

  get open(): boolean {
    return this.dialog.open;
  }

  toggle(): void {
    if (this.dialog.open) this.dialog.close();
    else {
      this.fill();
      this.dialog.showModal();
    }
  }

  private fill(): void {
    const columns = h("div", { class: "columns" });
    const sections = this.app.editor.allowed ? [...kKeys, kEditKeys] : kKeys;
    for (const [title, keys] of sections) {
      const list = h("dl");
      for (const [key, meaning] of keys) {
        const parts = key.split(" ").map((one) => h("kbd", {}, one));
        list.append(
          h("dt", {}, ...parts.flatMap((one, i) => (i === 0 ? [one] : [" ", one]))),
          h("dd", {}, meaning),
        );
      }
      columns.append(h("section", {}, h("h2", {}, title), list));
    }
    columns.append(this.closures(), this.tracking());
    const header = h(
      "header",
      {},
      h("h2", { id: "help-title" }, "Keys, and what is shown"),
      iconButton("close", "Close", "Esc", () => this.dialog.close()),
    );
    this.dialog.replaceChildren(header, columns);
  }

  private closures(): HTMLElement {
    const list = h("dl");
    for (const state of kClosureStates) {
      const { dash, mark, label, meaning } = kClosureWords[state];
      list.append(
        h("dt", {}, swatch(this.app.palette.closures[state], dash, mark)),
        h("dd", {}, h("b", {}, label), `: ${meaning}`),
      );
    }
    return h("section", {}, h("h2", {}, "Loop closures"), list);
  }

  private tracking(): HTMLElement {
    const localizing = this.app.model.about?.mode === "localizing";
    const states = localizing
      ? ["TRACKING", "DOUBTFUL", "LOST"]
      : ["tracked", "degenerate", "bridged", "lost"];
    const list = h("dl");
    for (const state of states) {
      const { label, mood, meaning } = trackingWords(state);
      list.append(
        h("dt", {}, h("span", { class: `chip state ${mood}` }, label)),
        h("dd", {}, meaning),
      );
    }
    const { frameTime } = this.app.map;
    const drawing = `A picture takes this page ${frameTime.toFixed(1)} ms of processor time.`;
    return h(
      "section",
      {},
      h("h2", {}, "State of tracking"),
      list,
      h("p", { class: "soft small" }, drawing),
    );
  }
}
