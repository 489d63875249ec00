import type { App } from "../app.ts";
import { clock, metres, optional, percent, significant } from "../format.ts";
import { type Closure, kClosureStates } from "../json_messages.ts";
import { kClosureWords } from "../words.ts";
import { ClosureDetail } from "./closure_detail.ts";
import { h, swatch } from "./dom.ts";

const kLineHeight = 28;

interface Column {
  label: string;
  title: string;
  value(closure: Closure): number | string | null;
  text(closure: Closure, start: number): string;
}

const kColumns: Column[] = [
  { label: "id", title: "number", value: (c) => c.id, text: (c) => String(c.id) },
  {
    label: "state",
    title: "state",
    value: (c) => c.state,
    text: (c) => kClosureWords[c.state].label,
  },
  {
    label: "time",
    title: "time of the second scan",
    value: (c) => c.toTime,
    text: (c, start) => optional(c.toTime, (t) => clock(t - start)),
  },
  {
    label: "score",
    title: "score",
    value: (c) => c.score,
    text: (c) => optional(c.score, (v) => significant(v, 2)),
  },
  {
    label: "overlap",
    title: "overlap",
    value: (c) => c.overlap,
    text: (c) => optional(c.overlap, percent),
  },
  {
    label: "σ",
    title: "standard deviation",
    value: (c) => c.sigma,
    text: (c) => optional(c.sigma, metres),
  },
];

/** Sorted; what has no value comes last in either direction. */
export function sortClosures(
  closures: Closure[],
  value: Column["value"],
  descending: boolean,
): Closure[] {
  const sign = descending ? -1 : 1;
  return [...closures].sort((one, other) => {
    const a = value(one);
    const b = value(other);
    if (a === null || b === null) return a === b ? one.id - other.id : a === null ? 1 : -1;
    const order = a < b ? -1 : a > b ? 1 : 0;
    return order !== 0 ? sign * order : one.id - other.id;
  });
}

/** All closures in a list of which only the lines in sight exist, and one of them in detail. */
export class ClosuresPanel {
  readonly panel = h("div", { class: "stack" });
  readonly detail: ClosureDetail;
  private sorted: Closure[] = [];
  private column = 0;
  private descending = false;
  private readonly filters = h("div", {
    class: "filters",
    role: "group",
    "aria-label": "Shown states",
  });
  private readonly heads: HTMLElement[] = [];
  private readonly body = h("div", { class: "body", role: "rowgroup" });
  private readonly table = h("div", {
    class: "table",
    role: "grid",
    tabindex: 0,
    "aria-label": "Loop closures",
  });
  private readonly empty = h("p", { class: "empty" });
  private readonly counts = new Map<string, HTMLElement>();

  constructor(private readonly app: App) {
    this.detail = new ClosureDetail(app, (step) => this.step(step));
    this.makeHeads();
    this.makeFilters();
    this.table.append(this.body);
    this.table.addEventListener("scroll", () => app.frames.request(this.showLines));
    this.table.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => app.frames.request(this.showLines)).observe(this.table);
    this.panel.append(this.filters, this.empty, this.table, this.detail.element);
    app.watch(["closures", "trajectory", "reset"], this.refresh);
    app.onChosen(this.refresh);
    app.onSelected(() => {
      this.reveal();
      this.showLines();
    });
  }

  private makeHeads(): void {
    const head = h("div", { class: "line heads", role: "row" });
    kColumns.forEach(({ label, title }, i) => {
      const button = h(
        "button",
        { type: "button", title: `Sort by ${title}`, onclick: () => this.sortBy(i) },
        label,
      );
      const cell = h("span", { role: "columnheader", "aria-sort": "none" }, button);
      this.heads.push(cell);
      head.append(cell);
    });
    this.table.append(head);
  }

  private makeFilters(): void {
    for (const state of kClosureStates) {
      const words = kClosureWords[state];
      const count = h("span", { class: "soft" });
      const box = h("input", {
        type: "checkbox",
        checked: this.app.settings.closures[state],
        onchange: () => {
          this.app.settings.closures[state] = box.checked;
          this.app.chosen();
        },
      });
      this.app.onChosen(() => (box.checked = this.app.settings.closures[state]));
      let key = swatch(this.app.palette.closures[state], words.dash, words.mark);
      this.app.onChosen(() => {
        const next = swatch(this.app.palette.closures[state], words.dash, words.mark);
        key.replaceWith(next);
        key = next;
      });
      this.counts.set(state, count);
      this.filters.append(
        h("label", { title: words.meaning, "data-state": state }, box, key, words.label, count),
      );
    }
  }

  private sortBy(i: number): void {
    this.descending = i === this.column && !this.descending;
    this.column = i;
    this.refresh();
    this.table.scrollTop = 0;
  }

  private readonly refresh = (): void => {
    const { model, settings } = this.app;
    const shown = model.closures.filter((one) => settings.closures[one.state]);
    this.sorted = sortClosures(shown, kColumns[this.column]?.value ?? (() => 0), this.descending);
    this.heads.forEach((cell, i) => {
      const sort = i !== this.column ? "none" : this.descending ? "descending" : "ascending";
      cell.setAttribute("aria-sort", sort);
    });
    for (const state of kClosureStates) {
      const count = model.closures.filter((one) => one.state === state).length;
      const element = this.counts.get(state);
      if (element) element.textContent = String(count);
    }
    this.empty.hidden = this.sorted.length > 0;
    this.empty.textContent =
      model.closures.length === 0
        ? "No loop closures yet. They come when the robot sees a place again."
        : "None of the shown states.";
    this.table.hidden = this.sorted.length === 0;
    this.table.setAttribute("aria-rowcount", String(this.sorted.length + 1));
    this.body.style.height = `${this.sorted.length * kLineHeight}px`;
    this.showLines();
  };

  private readonly showLines = (): void => {
    if (this.table.clientHeight === 0) return;
    const first = Math.max(0, Math.floor(this.table.scrollTop / kLineHeight) - 4);
    const count = Math.ceil(this.table.clientHeight / kLineHeight) + 8;
    const lines = this.sorted
      .slice(first, first + count)
      .map((one, i) => this.line(one, first + i));
    this.body.replaceChildren(...lines);
    const selected = this.app.selected;
    const shown = selected !== null && lines.some((line) => line.id === `closure-${selected}`);
    if (shown) this.table.setAttribute("aria-activedescendant", `closure-${selected}`);
    else this.table.removeAttribute("aria-activedescendant");
  };

  private line(closure: Closure, index: number): HTMLElement {
    const words = kClosureWords[closure.state];
    const colour = this.app.palette.closures[closure.state];
    const start = this.app.startTime;
    const line = h("div", {
      class: "line",
      role: "row",
      id: `closure-${closure.id}`,
      "aria-rowindex": index + 2,
      "aria-selected": String(closure.id === this.app.selected),
      onclick: () => {
        this.app.select(closure.id);
        this.app.goToClosure(closure);
      },
    });
    line.style.top = `${index * kLineHeight}px`;
    kColumns.forEach((column, i) => {
      const cell = h("span", { role: "gridcell" });
      if (i === 1) {
        const mark = swatch(colour, "none", words.mark, 14);
        mark.setAttribute("class", "dot");
        cell.append(mark);
      }
      cell.append(column.text(closure, start));
      line.append(cell);
    });
    return line;
  }

  /** Chooses the one that is so many lines further on. */
  step(by: number): void {
    if (this.sorted.length === 0) return;
    const at = this.sorted.findIndex((one) => one.id === this.app.selected);
    const wish = at < 0 ? (by > 0 ? 0 : this.sorted.length - 1) : at + by;
    const next = this.sorted[Math.min(this.sorted.length - 1, Math.max(0, wish))];
    if (next === undefined) return;
    this.app.select(next.id);
    this.app.goToClosure(next);
  }

  private reveal(): void {
    const at = this.sorted.findIndex((one) => one.id === this.app.selected);
    if (at < 0) return;
    const { table } = this;
    const top = at * kLineHeight;
    const room = table.clientHeight - 2 * kLineHeight;
    if (top < table.scrollTop) table.scrollTop = top;
    else if (top > table.scrollTop + room) table.scrollTop = top - Math.max(0, room);
  }

  private key(event: KeyboardEvent): void {
    if (event.target !== this.table) return;
    const page = Math.max(1, Math.floor(this.table.clientHeight / kLineHeight) - 2);
    const steps: Record<string, number> = {
      ArrowDown: 1,
      ArrowUp: -1,
      PageDown: page,
      PageUp: -page,
      Home: -this.sorted.length,
      End: this.sorted.length,
    };
    const by = steps[event.key];
    if (by === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    this.step(by);
  }
}
