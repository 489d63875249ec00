/** What a tool needs beside the map: its fields, by kind. */
import type { App } from "../app.ts";
import { ClosureTool } from "../edit/closure_tool.ts";
import type { Editor, EditTool, ToolKind } from "../edit/editor.ts";
import { OriginTool } from "../edit/origin_tool.ts";
import { areaOf } from "../edit/polygon.ts";
import { numberIn, PolygonTool } from "../edit/polygon_tool.ts";
import { StretchTool } from "../edit/stretch_tool.ts";
import { clock, grouped, metres } from "../format.ts";
import type { Pose } from "../geometry.ts";
import { figureWords } from "../words.ts";
import { h, setOff, setText } from "./dom.ts";
import { PlacePicker } from "./place_picker.ts";

const kDegree = Math.PI / 180;

export interface ToolWords {
  /** On its button; what it will do; on the button that does it. */
  label: string;
  meaning: string;
  send: string;
}

export const kToolWords: Record<ToolKind, ToolWords> = {
  add_closure: {
    label: "Add a closure",
    meaning:
      "Two places of the path are one. Their scans are registered about where you lay the second " +
      "one; what does not fit is refused.",
    send: "Add the closure",
  },
  ignore: {
    label: "Ignore a stretch",
    meaning:
      "The scans of the stretch are not drawn, not judged by, and part of no closure. The path " +
      "keeps its shape there.",
    send: "Ignore the stretch",
  },
  crop: {
    label: "Crop",
    meaning: "What lies outside of the polygon becomes unknown.",
    send: "Crop the map",
  },
  erase: {
    label: "Erase",
    meaning: "What was seen inside becomes free. What was never seen stays unknown.",
    send: "Erase inside",
  },
  keep_out: {
    label: "Keep-out zone",
    meaning: "A zone that robots do not enter. The map's picture stays as it is.",
    send: "Add the zone",
  },
  speed: {
    label: "Speed zone",
    meaning: "A zone in which robots go slowly. All zones of a map tell it in the same way.",
    send: "Add the zone",
  },
  origin: {
    label: "Set the origin",
    meaning: "The point becomes (0, 0) and, where you drag, that direction the one of x.",
    send: "Set the origin",
  },
};

export interface Form {
  fields: HTMLElement[];
  show(): void;
}

function textField(
  label: string,
  id: string,
  attributes: Record<string, string | number>,
  take: (text: string) => void,
): { line: HTMLElement; input: HTMLInputElement } {
  const input = h("input", { type: "text", id, autocomplete: "off", ...attributes });
  input.addEventListener("input", () => take(input.value));
  return { line: h("div", { class: "row" }, h("label", { for: id }, label), input), input };
}

function checkBox(
  label: string,
  id: string,
  take: (checked: boolean) => void,
): { line: HTMLElement; box: HTMLInputElement } {
  const box = h("input", { type: "checkbox", id, onchange: () => take(box.checked) });
  return { line: h("div", { class: "row" }, h("label", {}, box, label)), box };
}

function plainButton(label: string, id: string, act: () => void): HTMLButtonElement {
  return h("button", { type: "button", class: "plain", id, onclick: act }, label);
}

/** Writes a number where the reader is not writing one. */
function showNumber(input: HTMLInputElement, value: number | null, decimals: number): void {
  if (document.activeElement === input) return;
  input.value = value === null ? "" : value.toFixed(decimals);
}

function polygonForm(tool: PolygonTool, changed: () => void): Form {
  const words = h("p", { class: "soft small" });
  const box = plainButton("Box", "edit-box", () => {
    tool.boxing = !tool.boxing;
    changed();
  });
  const close = plainButton("Close it", "edit-close", () => tool.close());
  const back = plainButton("Take back", "edit-back", () => void tool.takeBack());
  const again = plainButton("Draw anew", "edit-anew", () => tool.clear());
  const fields: HTMLElement[] = [h("div", { class: "buttons" }, box, close, back, again), words];
  if (tool.kind === "keep_out" || tool.kind === "speed") {
    const name = textField("Name", "edit-name", { maxlength: 80 }, (text) => (tool.name = text));
    fields.push(name.line);
  }
  if (tool.kind === "speed") fields.push(...speedFields(tool));
  const show = () => {
    box.setAttribute("aria-pressed", String(tool.boxing));
    setOff(close, tool.closed || tool.points.length < 3);
    for (const button of [back, again]) setOff(button, tool.points.length === 0);
    const count = tool.points.length;
    const corners = count === 1 ? "1 corner" : `${count} corners`;
    const area = `, ${Math.abs(areaOf(tool.points)).toFixed(1)} m²`;
    setText(words, count === 0 ? "" : tool.closed ? `${corners}${area}.` : `${corners} so far.`);
  };
  return { fields, show };
}

function speedFields(tool: PolygonTool): HTMLElement[] {
  const field = { size: 6, inputmode: "decimal" };
  const percent = textField("Of the robot's speed [%]", "edit-percent", field, (text) => {
    tool.percent = text;
    if (text.trim() !== "") tool.limit = limit.input.value = "";
  });
  const limit = textField("Or at most [m/s]", "edit-limit", field, (text) => {
    tool.limit = text;
    if (text.trim() !== "") tool.percent = percent.input.value = "";
  });
  percent.input.value = tool.percent;
  return [percent.line, limit.line];
}

function stretchForm(app: App, tool: StretchTool): Form {
  const pickers = [new PlacePicker(app, tool, 0, "Begin"), new PlacePicker(app, tool, 1, "End")];
  const words = h("p", { class: "soft small", id: "edit-stretch" });
  const show = () => {
    for (const picker of pickers) picker.show();
    const { from, to, track } = tool;
    if (from === null || to === null) return setText(words, "");
    const seconds = Math.abs((track.t[to] ?? 0) - (track.t[from] ?? 0));
    let length = 0;
    for (let i = Math.min(from, to) + 1; i <= Math.max(from, to); i++)
      length += Math.hypot(track.x(i) - track.x(i - 1), track.y(i) - track.y(i - 1));
    const count = Math.abs(to - from) + 1;
    setText(
      words,
      `${grouped(count)} key ${count === 1 ? "scan" : "scans"}, ${clock(seconds)} min, ` +
        `${metres(length)} of the path.`,
    );
  };
  return { fields: [...pickers.map((one) => one.element), words], show };
}

/** Where the second place lies, in numbers; the scan that is dragged shows itself here. */
function guessFields(tool: ClosureTool): Form {
  // What is shown is rounded: of the three only the one that is written is taken.
  const take = (part: keyof Pose, unit: number) => (text: string) => {
    if (tool.guess !== null) tool.setGuess({ ...tool.guess, [part]: numberIn(text) * unit });
  };
  const field = { size: 7, inputmode: "decimal" };
  const inputs = [
    textField("Ahead [m]", "edit-x", field, take("x", 1)),
    textField("To the left [m]", "edit-y", field, take("y", 1)),
    textField("Turned [°]", "edit-yaw", field, take("yaw", kDegree)),
  ];
  const reset = plainButton("As the map has it", "edit-reset", () => tool.reset());
  const legend = h("legend", {}, "The second place, seen from the first");
  const lines = inputs.map(({ line }) => line);
  const guess = h("fieldset", { class: "guess" }, legend, ...lines, reset);
  const show = () => {
    const pose = tool.guess;
    const values = pose === null ? [] : [pose.x, pose.y, pose.yaw / kDegree];
    inputs.forEach(({ input }, i) => {
      input.disabled = pose === null || tool.withoutGuess;
      showNumber(input, values[i] ?? null, i === 2 ? 1 : 2);
    });
    setOff(reset, !tool.isMoved);
  };
  return { fields: [guess], show };
}

/** How it is searched, and whether what does not fit is taken. */
function searchFields(tool: ClosureTool, editor: Editor): Form {
  const without = checkBox("without a guess", "edit-without", (checked) => {
    tool.withoutGuess = checked;
    editor.changed();
  });
  const field = { size: 7, inputmode: "decimal", placeholder: "as usual" };
  const half = textField("Search within [m]", "edit-half", field, (text) => {
    tool.halfWindow = text;
  });
  const force = checkBox("force", "edit-force", (checked) => {
    tool.force = checked;
    editor.changed();
  });
  const attributes = { class: "warning small", id: "edit-force-words", hidden: true };
  const words = "It is taken however little fits, and never revoked: a wrong one spoils the map.";
  const warning = h("p", attributes, words);
  force.box.setAttribute("aria-describedby", "edit-force-words");
  return {
    fields: [without.line, half.line, force.line, warning],
    show: () => (warning.hidden = !tool.force),
  };
}

function closureForm(app: App, tool: ClosureTool): Form {
  const { editor } = app;
  const pickers = [
    new PlacePicker(app, tool, 0, "First place (1, dots)"),
    new PlacePicker(app, tool, 1, "Second place (2, crosses)"),
  ];
  const scans = h("p", { class: "soft small", id: "edit-scans" });
  const parts = [guessFields(tool), searchFields(tool, editor)];
  const result = h("p", { class: "small", id: "edit-result" });
  const show = () => {
    for (const one of [...pickers, ...parts]) one.show();
    setText(scans, scanWords(tool));
    const figures = editor.refused?.closure ?? null;
    setText(result, figures === null ? "" : `Refused with ${figureWords(figures)}.`);
  };
  const places = pickers.map((one) => one.element);
  return { fields: [...places, scans, ...parts.flatMap((one) => one.fields), result], show };
}

function scanWords(tool: ClosureTool): string {
  const none = [0, 1].filter((i) => tool.nodes[i] !== null && tool.scans[i] === null);
  if (none.length === 0) return "";
  return `No scan is at hand of ${none.length === 2 ? "both places" : "one of the places"}.`;
}

function originForm(tool: OriginTool): Form {
  const field = { size: 8, inputmode: "decimal" };
  const take = () => {
    const [x = NaN, y = NaN, yaw = NaN] = inputs.map(({ input }) => numberIn(input.value));
    if (Number.isFinite(x + y)) tool.set({ x, y }, Number.isFinite(yaw) ? yaw * kDegree : null);
  };
  const inputs = [
    textField("x [m]", "edit-x", field, take),
    textField("y [m]", "edit-y", field, take),
    textField("Direction of x [°]", "edit-yaw", { ...field, placeholder: "as it is" }, take),
  ];
  const show = () => {
    const { point, yaw } = tool;
    const degrees = yaw === null ? null : yaw / kDegree;
    // Half a point, while it is written, is the reader's.
    const writing = inputs.some(({ input }) => document.activeElement === input);
    if (point === null && writing) return;
    [point?.x ?? null, point?.y ?? null, degrees].forEach((value, i) => {
      const input = inputs[i]?.input;
      if (input !== undefined) showNumber(input, value, i === 2 ? 1 : 3);
    });
  };
  return { fields: inputs.map(({ line }) => line), show };
}

export function formFor(app: App, tool: EditTool): Form {
  const { editor } = app;
  if (tool instanceof PolygonTool) return polygonForm(tool, editor.changed);
  if (tool instanceof ClosureTool) return closureForm(app, tool);
  if (tool instanceof StretchTool) return stretchForm(app, tool);
  if (tool instanceof OriginTool) return originForm(tool);
  return { fields: [], show: () => undefined };
}
