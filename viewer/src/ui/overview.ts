import type { App } from "../app.ts";
import { clock, grouped, metres, optional, significant } from "../format.ts";
import { kVerdicts } from "../words.ts";
import { Filled, h, icon } from "./dom.ts";

/** Verdict, figures of the run, warnings. */
export class Overview {
  readonly panel = h("div");
  private readonly verdict = new Filled(h("section", { class: "block", "aria-label": "Verdict" }));
  private readonly figures = h("dl", { class: "figures" });
  private readonly warnings = new Filled(
    h("section", { class: "block", "aria-label": "Warnings" }),
  );
  private readonly values = new Map<string, HTMLElement>();

  constructor(private readonly app: App) {
    const run = h("section", { class: "block" }, h("h2", {}, "The run"), this.figures);
    this.panel.append(this.verdict.element, run, this.warnings.element);
    app.watch(["verdict", "about", "reset"], () => this.showVerdict());
    app.watch(["status", "reset"], () => this.showFigures());
    app.watch(["warnings", "playback", "about", "trajectory", "reset"], () => this.showWarnings());
  }

  private showVerdict(): void {
    const { verdict, about } = this.app.model;
    this.verdict.show([verdict, about?.mode], () => this.verdictParts());
  }

  private verdictParts(): Node[] {
    const { verdict, about } = this.app.model;
    const title = h("h2", {}, "Verdict on the map");
    const known = verdict !== null && verdict.verdict !== "" ? kVerdicts[verdict.verdict] : null;
    if (verdict === null || known === null) {
      const none = about?.mode === "localizing" ? "" : "None yet. It comes when the map is judged.";
      const words = verdict?.sentence || none;
      return words ? [title, h("p", { class: "empty" }, words)] : [];
    }
    const card = h(
      "div",
      { class: `verdict ${known.mood}`, id: "verdict" },
      h("div", { class: `head ${known.mood}` }, icon(verdict.verdict), known.label),
      h("p", {}, verdict.sentence),
    );
    if (verdict.reasons.length > 0) {
      card.append(h("ul", {}, ...verdict.reasons.map((reason) => h("li", {}, reason))));
    }
    if (!verdict.complete) {
      const words = "Not all was judged: the run goes on, or a part is missing.";
      card.append(h("p", { class: "soft small" }, words));
    }
    if (verdict.places.length > 0) card.append(this.placeList());
    return [title, card];
  }

  private placeList(): HTMLElement {
    const places = this.app.model.verdict?.places ?? [];
    const items = places.map((place, i) => {
      const act = () => this.app.map.goTo(place, 20);
      const words = place.text || `${place.x.toFixed(1)}, ${place.y.toFixed(1)}`;
      const attributes = { type: "button", class: "link small", onclick: act };
      return h("li", {}, h("button", attributes, h("b", {}, String(i + 1)), words));
    });
    return h("ul", { class: "place-list", "aria-label": "Places" }, ...items);
  }

  private showFigures(): void {
    const { status } = this.app.model;
    const count = (value: number | null | undefined) => optional(value ?? null, grouped);
    const rows: [string, string][] = [
      ["scans", count(status?.scans)],
      ["travelled", optional(status?.travelled ?? null, metres)],
      ["map", optional(status?.mapArea ?? null, (value) => `${grouped(value)} m²`)],
      ["submaps", count(status?.submaps)],
      ["closures", count(status?.closures)],
      ["rejected", count(status?.rejected)],
      ["real time", optional(status?.realtime || null, (value) => `× ${significant(value)}`)],
      ["memory", optional(status?.memory ?? null, (value) => `${grouped(value)} MB`)],
    ];
    for (const [name, text] of rows) {
      let value = this.values.get(name);
      if (value === undefined) {
        value = h("dd");
        this.values.set(name, value);
        this.figures.append(h("div", {}, h("dt", {}, name), value));
      }
      if (value.textContent !== text) value.textContent = text;
    }
  }

  private showWarnings(): void {
    const { model } = this.app;
    const what = [model.warnings, model.notes, model.canSeek, this.app.startTime];
    this.warnings.show(what, () => this.warningParts());
  }

  private warningParts(): Node[] {
    const { model, session } = this.app;
    const all = [...model.warnings, ...model.notes.map((text) => ({ t: null, text }))];
    const title = h("h2", {}, all.length > 0 ? `Warnings, ${all.length}` : "Warnings");
    if (all.length === 0) return [title, h("p", { class: "empty" }, "None.")];
    const start = this.app.startTime;
    const items = all.map(({ t, text }) => {
      const when = t === null ? "" : clock(t - start);
      const label = `Go to ${when}`;
      const act = () => session.seek(t ?? start);
      const attributes = { type: "button", class: "link", "aria-label": label, onclick: act };
      const shown = t !== null && model.canSeek ? h("button", attributes, when) : when;
      return h("li", {}, h("span", { class: "when" }, shown), h("span", {}, text));
    });
    const list = h("ul", { class: "warnings", tabindex: 0, "aria-label": "Warnings" }, ...items);
    return [title, list];
  }
}
