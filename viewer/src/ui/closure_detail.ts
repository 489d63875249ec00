import type { App } from "../app.ts";
import { clock, metres, optional, percent, significant } from "../format.ts";
import { compose, inverse, type Pose } from "../geometry.ts";
import { type Closure, type Evidence, readEvidence } from "../json_messages.ts";
import { kClosureWords } from "../words.ts";
import { h, iconButton, swatch } from "./dom.ts";
import { PairView } from "./pair_view.ts";

const kKept = 32;

/** One closure: its scans, figures, and why it was or was not accepted. */
export class ClosureDetail {
  readonly element = h("section", { class: "detail", "aria-label": "Closure", hidden: true });
  readonly pair: PairView;
  evidence: Evidence | null = null;
  asMeasured = true;
  private readonly title = h("h3", { tabindex: -1 });
  private readonly words = h("p");
  private readonly canvas = h("canvas", { role: "img" });
  private readonly keys = h("span");
  private readonly reason = h("div", { class: "reason" });
  private readonly figures = h("dl", { class: "figures" });
  private readonly remove = h("button", { type: "button", class: "plain", id: "closure-delete" });
  /** By closure and its nodes: numbers may be given anew while a run is mapped. */
  private readonly kept = new Map<string, Evidence>();
  private readonly radios: HTMLInputElement[] = [];
  private asked = 0;

  constructor(
    private readonly app: App,
    neighbour: (step: number) => void,
  ) {
    this.pair = new PairView(this.canvas, () => app.palette);
    const head = h(
      "header",
      {},
      this.title,
      iconButton("left", "Previous closure", "B", () => neighbour(-1)),
      iconButton("right", "Next closure", "N", () => neighbour(1)),
      iconButton("zoom", "Zoom to it", "Z", () => this.zoomTo()),
      iconButton("close", "Close", "Esc", () => app.select(null)),
    );
    const under = h("div", { class: "under" }, this.keys, this.choice());
    const pair = h("div", { class: "pair" }, this.canvas, this.words);
    this.remove.textContent = "Delete this closure (Del)";
    this.remove.addEventListener("click", () => this.delete());
    const actions = h("div", { class: "buttons" }, this.remove);
    this.element.append(head, pair, under, this.reason, this.figures, actions);
    app.watch(["about"], () => this.showFigures());
    app.onSelected(() => this.select());
    app.watch(["closures"], () => this.showFigures());
    app.watch(["trajectory"], () => {
      if (app.selected !== null) this.showPair();
    });
    new ResizeObserver(() => this.pair.draw()).observe(this.canvas);
  }

  private choice(): HTMLElement {
    const one = (value: boolean, label: string) => {
      const attributes = { type: "radio", name: "evidence", checked: value === this.asMeasured };
      const radio = h("input", { ...attributes, onchange: () => this.show(value) });
      this.radios.push(radio);
      return h("label", {}, radio, label);
    };
    return h(
      "div",
      { class: "choice", role: "radiogroup", "aria-label": "Where the second scan lies" },
      one(true, "as measured"),
      one(false, "as the graph has it"),
    );
  }

  private show(asMeasured: boolean): void {
    this.asMeasured = asMeasured;
    this.showPair();
  }

  toggle(): void {
    if (this.app.selected === null) return;
    this.show(!this.asMeasured);
    const [measured, graph] = this.radios;
    if (measured && graph) (this.asMeasured ? measured : graph).checked = true;
  }

  /** As an edit that can be undone. */
  delete(): void {
    void this.app.editor.deleteClosure(this.app.closure(this.app.selected));
  }

  zoomTo(): void {
    const closure = this.app.closure(this.app.selected);
    if (closure !== null) this.app.goToClosure(closure);
  }

  private select(): void {
    const id = this.app.selected;
    this.element.hidden = id === null;
    if (id === null) return;
    this.evidence = this.kept.get(this.keyOf(id)) ?? null;
    this.words.textContent = this.evidence === null ? "Fetching both scans …" : "";
    this.showFigures();
    this.showPair();
    void this.fetch(id);
  }

  private keyOf(id: number): string {
    const closure = this.app.closure(id);
    return `${id} ${closure?.from} ${closure?.to}`;
  }

  private async fetch(id: number): Promise<void> {
    const mine = ++this.asked;
    const failed = (why: string) => {
      if (mine === this.asked && this.evidence === null) this.words.textContent = why;
    };
    try {
      const answer = await fetch(this.app.session.api(`api/closures/${id}`));
      const evidence = answer.ok ? readEvidence(await answer.text()) : null;
      if (evidence === null) {
        failed(
          answer.status === 404
            ? "The scans of this closure were not kept."
            : "The server's answer could not be read.",
        );
        return;
      }
      this.kept.set(this.keyOf(id), evidence);
      const oldest = this.kept.keys().next().value;
      if (this.kept.size > kKept && oldest !== undefined) this.kept.delete(oldest);
      if (mine !== this.asked) return;
      this.evidence = evidence;
      this.words.textContent = "";
      this.showPair();
      this.showFigures();
    } catch {
      failed("The server does not answer.");
    }
  }

  showPair(): void {
    const { evidence, app } = this;
    const closure = app.closure(app.selected);
    const graph = closure === null ? null : this.graphPose(closure);
    const shown = evidence === null || graph === null ? evidence : { ...evidence, graph };
    const heading = closure === null ? 0 : (app.model.track.pose(closure.from)?.yaw ?? 0);
    this.pair.show(shown, this.asMeasured, heading);
    const [first = "", second = ""] = app.palette.drives;
    const start = app.startTime;
    const key = (mark: string, colour: string, label: string, t: number | null) => {
      const words = t === null ? label : `${label}, ${clock(t - start)}`;
      return h("span", { class: "key" }, swatch(colour, "none", mark, 14), words);
    };
    this.keys.replaceChildren(
      key("disc", first, "first", closure?.fromTime ?? evidence?.from.t ?? null),
      key("cross", second, "second", closure?.toTime ?? evidence?.to.t ?? null),
    );
    const how = this.asMeasured ? "as measured" : "as the graph has it";
    const points = evidence ? (evidence.from.points.length + evidence.to.points.length) / 2 : 0;
    this.canvas.setAttribute("aria-label", `Both scans ${how}, ${points} points`);
  }

  /** As the graph has it now, which may have been solved since the scans were fetched. */
  private graphPose(closure: Closure): Pose | null {
    const { track } = this.app.model;
    const from = track.pose(closure.from);
    const to = track.pose(closure.to);
    if (from !== null && to !== null) return compose(inverse(from), to);
    return this.evidence?.graph ?? null;
  }

  private showFigures(): void {
    const { app, evidence } = this;
    const closure = app.closure(app.selected);
    if (closure === null) {
      if (app.selected !== null && app.model.closures.length > 0) app.select(null);
      return;
    }
    this.remove.hidden = !app.editor.allowed || closure.state !== "standing";
    const words = kClosureWords[closure.state];
    this.title.textContent = `Closure ${closure.id}, ${words.label}`;
    const why = closure.reason
      ? `${words.meaning.replace(/\.$/, ":")} ${closure.reason}`
      : words.meaning;
    this.reason.replaceChildren(h("p", {}, why.replace(/\.?$/, ".")));
    const rows = figuresOf(closure);
    const graph = this.graphPose(closure);
    if (evidence !== null && graph !== null) {
      const apart = compose(inverse(evidence.measured), graph);
      const degrees = (Math.abs(apart.yaw) * 180) / Math.PI;
      const length = Math.hypot(apart.x, apart.y);
      rows.push(["graph – measured", `${metres(length)}, ${degrees.toFixed(2)}°`]);
    }
    const cells = rows.map(([name, text]) => h("div", {}, h("dt", {}, name), h("dd", {}, text)));
    this.figures.replaceChildren(...cells);
  }
}

function figuresOf(closure: Closure): [string, string][] {
  const submaps = [closure.fromSubmap, closure.toSubmap].map((one) => one ?? "–").join(" – ");
  return [
    ["score", optional(closure.score, significant)],
    ["second score", optional(closure.secondScore, significant)],
    ["overlap", optional(closure.overlap, percent)],
    ["agreement", optional(closure.agreement, percent)],
    ["χ²", optional(closure.chi2, significant)],
    ["σ", optional(closure.sigma, metres)],
    ["nodes", `${closure.from} – ${closure.to}`],
    ["submaps", submaps],
    ["found by", closure.byAppearance ? "appearance" : "position"],
  ];
}
