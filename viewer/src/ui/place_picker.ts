import type { App } from "../app.ts";
import type { PlacesTool } from "../edit/stretch_tool.ts";
import { nodeAt } from "../edit/visits.ts";
import { clock, parseClock } from "../format.ts";
import { h, setText } from "./dom.ts";

/** One of two places on the path: by a click on the map, by its time, or node by node. */
export class PlacePicker {
  readonly element: HTMLElement;
  private readonly aim: HTMLButtonElement;
  private readonly time: HTMLInputElement;
  private readonly slider: HTMLInputElement;
  private readonly visits: HTMLSelectElement;
  private readonly visitLine: HTMLElement;
  private readonly words = h("span", { class: "soft small" });

  constructor(
    private readonly app: App,
    private readonly tool: PlacesTool,
    private readonly which: 0 | 1,
    label: string,
  ) {
    const id = `place-${which}`;
    this.aim = h("button", { type: "button", class: "plain", onclick: () => this.toggle() });
    this.aim.textContent = "On the map";
    this.aim.setAttribute("aria-label", `${label}: choose it on the map`);
    this.time = h("input", {
      type: "text",
      id: `${id}-time`,
      inputmode: "decimal",
      size: 9,
      placeholder: "m:ss",
      autocomplete: "off",
      onchange: () => this.takeTime(),
    });
    this.slider = h("input", {
      type: "range",
      id: `${id}-node`,
      min: 0,
      step: 1,
      "aria-label": `${label}, node by node`,
      oninput: () => tool.chooseAnew(which, Number(this.slider.value)),
    });
    this.visits = h("select", {
      id: `${id}-visit`,
      onchange: () => tool.choose(which, Number(this.visits.value)),
    });
    this.visitLine = h(
      "div",
      { class: "row" },
      h("label", { for: `${id}-visit` }, "Visits there"),
      this.visits,
    );
    const time = h("label", { for: `${id}-time` }, "Time");
    this.element = h(
      "fieldset",
      { class: "place-picker" },
      h("legend", {}, label),
      h("div", { class: "row" }, time, this.time, this.aim),
      this.slider,
      this.visitLine,
      this.words,
    );
  }

  private toggle(): void {
    const { tool, which } = this;
    tool.aim(tool.target === which ? null : which);
    if (tool.target === which) this.app.announce(tool.instruction());
  }

  private takeTime(): void {
    const seconds = parseClock(this.time.value);
    const { track } = this.app.model;
    const node = seconds === null ? null : nodeAt(track, this.app.startTime + seconds);
    this.time.setAttribute("aria-invalid", String(node === null));
    if (node === null) {
      this.app.editor.say("Write the time as minutes and seconds, such as 2:13.4.", true);
      return;
    }
    if (this.tool.target === this.which) this.tool.target = null;
    this.tool.chooseAnew(this.which, node);
  }

  focus(): void {
    this.time.focus();
  }

  show(): void {
    const { tool, which, app } = this;
    const { track } = app.model;
    const node = tool.nodes[which] ?? null;
    this.aim.setAttribute("aria-pressed", String(tool.target === which));
    this.slider.max = String(Math.max(0, track.length - 1));
    const t = node === null ? null : (track.t[node] ?? 0) - app.startTime;
    if (node !== null) this.slider.value = String(node);
    const words = t === null ? "not chosen" : `${clock(t, 1)}, node ${node}`;
    this.slider.setAttribute("aria-valuetext", words);
    if (document.activeElement !== this.time) this.time.value = t === null ? "" : clock(t, 1);
    if (t !== null) this.time.removeAttribute("aria-invalid");
    setText(this.words, words);
    this.showVisits(node);
  }

  private showVisits(node: number | null): void {
    const visits = this.tool.visits[this.which] ?? [];
    this.visitLine.hidden = visits.length < 2;
    const key = visits.map((one) => one.node).join(" ");
    if (this.visits.dataset["key"] !== key) {
      this.visits.dataset["key"] = key;
      this.visits.replaceChildren(
        ...visits.map((one) =>
          h("option", { value: one.node }, clock(one.t - this.app.startTime, 1)),
        ),
      );
    }
    if (node === null) return;
    const near = visits.reduce<number | null>(
      (best, one) =>
        best === null || Math.abs(one.node - node) < Math.abs(best - node) ? one.node : best,
      null,
    );
    this.visits.value = String(near);
  }
}
