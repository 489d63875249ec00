import type { App } from "../app.ts";
import type { Message } from "../edit/editor.ts";
import { PolygonTool } from "../edit/polygon_tool.ts";
import { h, iconButton, need, setText } from "./dom.ts";

const kToldFor = 6_000;

/** On the map: what the tool in hand wants next, what is being done, and what went wrong. */
export class EditWords {
  private readonly host = need("edit-words");
  private readonly text = h("span");
  private readonly close: HTMLButtonElement;
  private readonly next: HTMLButtonElement;
  private said = "";
  /** What was done is told for a while. */
  private told: Message | null = null;
  private timer = 0;

  constructor(
    private readonly app: App,
    private readonly toForm: () => void,
  ) {
    const { editor } = app;
    const plain = { type: "button", class: "plain" };
    this.close = h("button", { ...plain, id: "edit-words-close" }, "Close it");
    this.close.addEventListener("click", () => {
      if (editor.tool instanceof PolygonTool) editor.tool.close();
    });
    this.next = h("button", { ...plain, id: "edit-words-next" }, "Continue");
    this.next.addEventListener("click", () => this.toForm());
    const end = iconButton("close", "Close", "Esc", () => this.dismiss());
    this.host.append(this.text, this.close, this.next, end);
    editor.on(() => this.show());
    app.watch(["edits", "about", "connection", "reset"], () => this.show());
  }

  /** What the tool in hand wants; without any what was done, for a few seconds. */
  private quietWords(): string {
    const { tool, message } = this.app.editor;
    if (tool !== null) return tool.instruction();
    if (message !== this.told) {
      this.told = message;
      window.clearTimeout(this.timer);
      this.timer = window.setTimeout(() => {
        this.timer = 0;
        this.show();
      }, kToldFor);
    }
    return this.timer === 0 ? "" : message.text;
  }

  private dismiss(): void {
    const { editor } = this.app;
    if (editor.tool !== null && !editor.message.bad) editor.cancel();
    else editor.say("");
  }

  private show(): void {
    const { editor } = this.app;
    const { tool, message } = editor;
    const { busy } = editor.client;
    const words = busy !== "" ? busy : message.bad ? message.text : this.quietWords();
    this.host.hidden = words === "" || !editor.allowed;
    this.host.classList.toggle("bad", busy === "" && message.bad);
    this.host.classList.toggle("busy", busy !== "");
    setText(this.text, words);
    // What went wrong is announced where it is said.
    const spoken = busy === "" && words === message.text ? "" : words;
    if (spoken !== "" && spoken !== this.said && editor.allowed) this.app.announce(spoken);
    this.said = spoken;
    const open = tool instanceof PolygonTool && !tool.closed;
    this.close.hidden = !open || tool.points.length < 3;
    this.next.hidden = tool === null || open || tool.problem() !== null;
  }
}
