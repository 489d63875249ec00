import type { App } from "../app.ts";
import { type EditTool, kToolKinds, type ToolKind } from "../edit/editor.ts";
import { type Edit, isMarker } from "../edits.ts";
import { significant } from "../format.ts";
import { editWords, figureWords, kVerdicts, shiftWords } from "../words.ts";
import { Filled, h, icon, need, setOff, setText } from "./dom.ts";
import { type Form, formFor, kToolWords } from "./edit_forms.ts";

function verdictParts(word: Edit["verdict"]): (Node | string)[] {
  if (word === "") return ["not judged"];
  const { label, mood } = kVerdicts[word];
  return [h("span", { class: `mood ${mood}` }, icon(word), label)];
}

/** The edits, what can be done, and the tool in hand. */
export class EditPanel {
  readonly panel = h("div");
  private readonly map = new Filled(
    h("section", { class: "block", "aria-label": "The edited map" }),
  );
  private readonly message = h("p", { class: "edit-message", id: "edit-message", hidden: true });
  private readonly buttons = h("div", { class: "edit-tools" });
  private readonly tools = h("section", { class: "block" }, h("h2", {}, "Tools"), this.buttons);
  private readonly form = h("section", { class: "block edit-form", hidden: true });
  private readonly list = new Filled(h("ol", { class: "edits", "aria-label": "Edits" }));
  private readonly title = h("h2");
  private readonly undo: HTMLButtonElement;
  private readonly save: HTMLButtonElement;
  private readonly send: HTMLButtonElement;
  private readonly saved = h("p", { class: "soft small", id: "edit-saved" });
  private readonly command = h("code", { id: "edit-command", tabindex: 0 });
  private readonly commandLine: HTMLElement;
  private readonly openers = new Map<ToolKind, HTMLButtonElement>();
  private shownTool: EditTool | null = null;
  private shownKind: ToolKind | null = null;
  private shownForm: Form | null = null;

  constructor(
    private readonly app: App,
    /** A tool has been taken or put away: the map is wanted, or the panel. */
    private readonly wanted: (what: "map" | "panel") => void,
  ) {
    const { editor } = app;
    const plain = (id: string, label: string, title: string, act: () => void) =>
      h("button", { type: "button", class: "plain", id, title, onclick: act }, label);
    this.undo = plain("edit-undo", "Undo", "Undo the last edit (Ctrl+Z)", () => void editor.undo());
    this.save = plain("edit-save", "Save", "Save the list of edits", () => void editor.save());
    this.send = h("button", { type: "button", class: "plain main", id: "edit-send" });
    this.send.addEventListener("click", () => void editor.send());
    const copy = plain("edit-copy", "Copy", "Copy the command", () => void this.copy());
    this.commandLine = h(
      "div",
      { class: "command" },
      h("p", { class: "soft small" }, "The same without the page, when it is saved:"),
      h("div", {}, this.command, copy),
    );
    this.command.setAttribute("aria-label", "Command");
    this.makeTools();
    const list = h("section", { class: "block" }, this.title);
    list.append(
      h("div", { class: "buttons" }, this.undo, this.save, this.saved),
      this.list.element,
      this.commandLine,
    );
    this.panel.append(this.message, this.form, this.tools, this.map.element, list);
    editor.on(() => this.show());
    app.watch(["edits", "about", "connection", "reset"], () => this.show());
    app.onChosen(() => this.show());
  }

  private makeTools(): void {
    const { editor } = this.app;
    for (const kind of kToolKinds) {
      const { label, meaning } = kToolWords[kind];
      const attributes = { type: "button", class: "plain", id: `edit-${kind}`, title: meaning };
      const button = h("button", attributes, label);
      button.addEventListener("click", () => this.begin(kind));
      this.openers.set(kind, button);
      this.buttons.append(button);
    }
    const straighten = h("button", { type: "button", class: "plain", id: "edit-straighten" });
    straighten.textContent = "Straighten";
    straighten.title = "The map turns, by 45 degrees at most, until its walls run along x and y.";
    straighten.addEventListener("click", () => void editor.straighten());
    this.buttons.append(straighten);
    const words = "To delete a closure choose it on the map or in the list, and press Delete.";
    this.tools.append(h("p", { class: "soft small" }, words));
  }

  private begin(kind: ToolKind): void {
    this.app.editor.begin(kind);
    this.wanted("map");
    this.show();
    const byTime = kind === "add_closure" || kind === "ignore";
    const first = byTime ? this.form.querySelector("h3") : need("overlay");
    if (first instanceof HTMLElement) first.focus({ preventScroll: true });
  }

  /** To what is left to do with the tool in hand: a name, or to send it. */
  toForm(): void {
    this.wanted("panel");
    this.show();
    const field = this.form.querySelector<HTMLElement>("#edit-name");
    (field ?? this.send).focus();
  }

  private show(): void {
    const { editor } = this.app;
    if (!editor.allowed) return;
    this.showTool();
    this.showMessage();
    this.showList();
    this.showMap();
    this.shownForm?.show();
  }

  private showTool(): void {
    const { tool, kind } = this.app.editor;
    if (tool === this.shownTool) return;
    const hadFocus = this.form.contains(document.activeElement);
    this.shownTool = tool;
    this.form.hidden = tool === null;
    this.tools.hidden = tool !== null;
    if (tool === null || kind === null) {
      this.shownForm = null;
      this.form.replaceChildren();
      const opener = this.shownKind === null ? undefined : this.openers.get(this.shownKind);
      if (hadFocus) opener?.focus();
      this.shownKind = null;
      return;
    }
    this.shownKind = kind;
    const { label, meaning, send } = kToolWords[kind];
    this.shownForm = formFor(this.app, tool);
    this.send.textContent = send;
    const cancel = () => this.app.editor.cancel();
    const attributes = { type: "button", class: "plain", id: "edit-cancel", onclick: cancel };
    this.form.setAttribute("aria-label", label);
    this.form.replaceChildren(
      h("h3", { tabindex: -1 }, label),
      h("p", { class: "small" }, meaning),
      ...this.shownForm.fields,
      h("div", { class: "buttons" }, this.send, h("button", attributes, "Cancel (Esc)")),
    );
  }

  private showMessage(): void {
    const { editor, model } = this.app;
    const { busy } = editor.client;
    const lost = model.connection.state !== "open";
    const { text, bad } = lost
      ? { text: "No connection. The list is the server's: it is asked for again.", bad: true }
      : busy !== ""
        ? { text: busy, bad: false }
        : editor.message;
    this.message.hidden = text === "";
    this.message.classList.toggle("bad", bad);
    this.message.classList.toggle("busy", busy !== "");
    setText(this.message, text);
    this.panel.setAttribute("aria-busy", String(busy !== ""));
  }

  private showList(): void {
    const { editor, model } = this.app;
    const state = model.edits;
    const edits = state?.edits ?? [];
    // Markers between edits are for the file.
    const shown = edits.filter((edit) => !isMarker(edit));
    const count = shown.length;
    setText(this.title, count > 0 ? `Edits, ${count}` : "Edits");
    const none = state === null ? "The list is asked for …" : "None yet.";
    this.list.show(count > 0 ? shown : none, () =>
      count > 0 ? shown.map((edit) => this.item(edit)) : [h("li", { class: "empty" }, none)],
    );
    const busy = editor.client.busy !== "";
    setOff(this.undo, busy || count === 0);
    setOff(this.save, busy || state === null);
    setOff(this.send, busy);
    for (const button of this.buttons.querySelectorAll("button")) setOff(button, busy);
    const file = state?.file ?? "";
    setText(this.save, file === "" ? "Save" : `Save as ${file}`);
    const saved =
      state === null || state.saved < 0
        ? "Not saved yet."
        : state.saved === state.revision
          ? "Saved."
          : "Changed since it was saved.";
    setText(this.saved, saved);
    this.commandLine.hidden = (state?.command ?? "") === "";
    setText(this.command, state?.command ?? "");
  }

  private item(edit: Edit): HTMLElement {
    const words = editWords(edit);
    const item = h("li", { class: edit.applied ? "" : "refused" });
    const head = h("div", { class: "head" }, h("b", {}, words));
    if (!edit.applied) head.append(h("span", { class: "mood bad" }, icon("bad"), "refused"));
    item.append(head, h("p", {}, edit.told));
    if (edit.closure !== null)
      item.append(h("p", { class: "soft small" }, figureWords(edit.closure)));
    if (!edit.applied) return item;
    const time = edit.seconds === null ? "" : ` ${significant(edit.seconds, 2)} s.`;
    item.append(h("p", { class: "soft small" }, `${shiftWords(edit.shift)}${time}`));
    const verdict = h("p", { class: "small" }, "Verdict: ", ...verdictParts(edit.verdictBefore));
    if (edit.verdict !== edit.verdictBefore) verdict.append(" → ", ...verdictParts(edit.verdict));
    item.append(verdict);
    return item;
  }

  private showMap(): void {
    const state = this.app.model.edits;
    const drawn = state === null || state.drawn >= state.revision;
    const what = state && [state.verdict, state.sentence, state.shift, drawn];
    this.map.show(what, () => {
      if (state === null) return [];
      const words = drawn
        ? "The map in sight is drawn with all edits."
        : "The map in sight is being drawn with the last edit …";
      const shift = shiftWords(state.shift);
      return [
        h("h2", {}, "The map with its edits"),
        h("p", {}, ...verdictParts(state.verdict)),
        h("p", {}, state.sentence),
        h("p", { class: "small" }, shift === "" ? "" : `Against the map without edits: ${shift}`),
        h("p", { class: drawn ? "soft small" : "small busy", id: "edit-drawn" }, words),
      ];
    });
  }

  private async copy(): Promise<void> {
    const text = this.command.textContent ?? "";
    try {
      await navigator.clipboard.writeText(text);
      this.app.editor.say("The command is copied.");
    } catch {
      // Without a safe connection a browser lets nobody write there: it is marked, ready to copy.
      window.getSelection()?.selectAllChildren(this.command);
      this.app.editor.say("The command is marked: copy it with Ctrl+C.");
    }
  }
}
