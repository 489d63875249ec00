import type { App } from "../app.ts";
import { clock, significant } from "../format.ts";
import type { Series } from "../series.ts";
import { figureLabel } from "../words.ts";
import { h, setText } from "./dom.ts";

const kFirstPlots = 4;

interface Plot {
  name: string;
  figure: HTMLElement;
  canvas: HTMLCanvasElement;
  value: HTMLElement;
}

/** Figures over time, each by name; the pointer tells the value, and a click goes there. */
export class PlotsPanel {
  readonly panel = h("div");
  private readonly choices = h("div");
  private readonly host = h("div");
  private readonly from = h("span");
  private readonly to = h("span");
  private readonly axis = h("div", { class: "axis" }, this.from, this.to);
  private readonly empty = h("p", { class: "empty" }, "No figures yet.");
  private readonly plots = new Map<string, Plot>();
  private readonly boxes = new Map<string, HTMLInputElement>();
  private hover: number | null = null;
  visible = false;
  readonly refresh = () => this.show();

  constructor(private readonly app: App) {
    const details = h("details", { open: true }, h("summary", {}, "Which figures"), this.choices);
    this.panel.append(details, this.empty, this.host, this.axis);
    app.watch(["status", "reset", "time"], () => this.show());
    app.onChosen(() => this.show());
    new ResizeObserver(() => this.app.frames.request(this.refresh)).observe(this.host);
  }

  private chosen(): string[] {
    const names = [...this.app.model.series.keys()];
    const { plots } = this.app.settings;
    return plots === null
      ? names.slice(0, kFirstPlots)
      : names.filter((name) => plots.includes(name));
  }

  show(): void {
    const { series } = this.app.model;
    this.empty.hidden = series.size > 0;
    this.showChoices();
    const chosen = this.chosen();
    const [from, to] = this.span();
    this.axis.hidden = series.size === 0 || chosen.length === 0;
    setText(this.from, clock(from - this.app.startTime, 1));
    setText(this.to, clock(to - this.app.startTime, 1));
    for (const [name, plot] of this.plots) {
      if (chosen.includes(name)) continue;
      plot.figure.remove();
      this.plots.delete(name);
    }
    for (const name of chosen) {
      const plot = this.plots.get(name) ?? this.addPlot(name);
      const values = series.get(name);
      if (this.visible && values !== undefined) this.draw(plot, values);
    }
  }

  private showChoices(): void {
    const names = [...this.app.model.series.keys()];
    if (names.length === this.boxes.size && names.every((name) => this.boxes.has(name))) return;
    this.boxes.clear();
    const chosen = this.chosen();
    const lines = names.map((name) => {
      const box = h("input", {
        type: "checkbox",
        value: name,
        checked: chosen.includes(name),
        onchange: () => {
          this.app.settings.plots = names.filter((one) => this.boxes.get(one)?.checked);
          this.app.chosen();
        },
      });
      this.boxes.set(name, box);
      return h("div", { class: "row" }, h("label", {}, box, figureLabel(name)));
    });
    this.choices.replaceChildren(...lines);
  }

  private addPlot(name: string): Plot {
    const value = h("b");
    const canvas = h("canvas", { tabindex: 0, role: "img", "aria-label": figureLabel(name) });
    const caption = h("figcaption", {}, h("span", {}, figureLabel(name)), value);
    const figure = h("figure", { class: "plot", "data-name": name }, caption, canvas);
    canvas.addEventListener("pointermove", (event) => {
      this.point(this.timeAt(canvas, event));
    });
    canvas.addEventListener("pointerleave", () => this.point(null));
    canvas.addEventListener("click", (event) => this.app.session.seek(this.timeAt(canvas, event)));
    canvas.addEventListener("keydown", (event) => this.key(event));
    canvas.addEventListener("blur", () => this.point(null));
    this.host.append(figure);
    const plot = { name, figure, canvas, value };
    this.plots.set(name, plot);
    return plot;
  }

  private point(time: number | null): void {
    this.hover = time;
    this.app.frames.request(this.refresh);
  }

  /** With a plot in focus, arrows move what is pointed at, Enter goes there. */
  private key(event: KeyboardEvent): void {
    const [low, high] = this.span();
    const at = this.hover ?? this.app.model.time ?? high;
    const step = (high - low) / 50;
    const to: Record<string, number> = {
      ArrowLeft: at - step,
      ArrowRight: at + step,
      Home: low,
      End: high,
    };
    const next = to[event.key];
    if (next !== undefined) this.point(Math.min(high, Math.max(low, next)));
    else if (event.key === "Enter") this.app.session.seek(at);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** All plots share the time from the first value to the last. */
  private span(): [number, number] {
    let low = Infinity;
    let high = -Infinity;
    for (const { length, begin, end } of this.app.model.series.values()) {
      if (length === 0) continue;
      low = Math.min(low, begin[0] ?? low);
      high = Math.max(high, end[length - 1] ?? high);
    }
    return low <= high ? [low, Math.max(high, low + 1)] : [0, 1];
  }

  private timeAt(canvas: HTMLCanvasElement, event: MouseEvent): number {
    const box = canvas.getBoundingClientRect();
    const [low, high] = this.span();
    return low + ((event.clientX - box.left) / Math.max(1, box.width)) * (high - low);
  }

  private draw({ canvas, value, name }: Plot, series: Series): void {
    const ratio = Math.min(3, window.devicePixelRatio || 1);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const context = canvas.getContext("2d");
    if (context === null || width === 0) return;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    context.scale(ratio, ratio);
    const [from, to] = this.span();
    const range = rangeOf(series);
    const x = (t: number) => ((t - from) / (to - from)) * width;
    const y = (v: number) =>
      height - 8 - ((v - range.low) / (range.high - range.low)) * (height - 16);
    const style = getComputedStyle(canvas);
    const [ink, soft, accent, raised] = ["--ink", "--soft", "--accent", "--raised"].map((one) =>
      style.getPropertyValue(one),
    );
    this.curve(context, series, x, y, accent ?? "");
    context.fillStyle = soft ?? "";
    context.font = '10.5px system-ui, "DejaVu Sans", sans-serif';
    context.strokeStyle = raised ?? "";
    context.lineWidth = 3;
    for (const [text, at] of [
      [significant(range.high), 12],
      [significant(range.low), height - 4],
    ] as const) {
      context.strokeText(text, 5, at);
      context.fillText(text, 5, at);
    }
    const shown = this.hover ?? this.app.model.time;
    if (shown !== null && series.length > 0) {
      context.fillStyle = ink ?? "";
      context.globalAlpha = this.hover === null ? 0.35 : 0.8;
      context.fillRect(Math.round(x(shown)), 0, 1, height);
      context.globalAlpha = 1;
    }
    const i = this.hover === null ? series.length - 1 : series.nearest(this.hover);
    const text = i >= 0 ? this.words(series, i) : "–";
    if (value.textContent !== text) value.textContent = text;
    canvas.setAttribute("aria-label", `${figureLabel(name)}: now ${text}`);
  }

  private words(series: Series, i: number): string {
    const low = series.low[i] ?? 0;
    const high = series.high[i] ?? 0;
    const number =
      low === high || this.hover === null
        ? significant(series.last[i] ?? 0)
        : `${significant(low)} … ${significant(high)}`;
    return this.hover === null
      ? number
      : `${number} at ${clock((series.end[i] ?? 0) - this.app.startTime)}`;
  }

  private curve(
    context: CanvasRenderingContext2D,
    series: Series,
    x: (t: number) => number,
    y: (v: number) => number,
    colour: string,
  ): void {
    context.beginPath();
    let column = NaN;
    let low = 0;
    let high = 0;
    // What falls on one column of pixels is one stroke from its least to its largest.
    const flush = () => {
      if (Number.isNaN(column)) return;
      context.lineTo(column, y(high));
      if (high !== low) context.lineTo(column, y(low));
    };
    for (let i = 0; i < series.length; i++) {
      const next = Math.round(x(series.end[i] ?? 0) * 2) / 2;
      if (next !== column) {
        flush();
        column = next;
        low = Infinity;
        high = -Infinity;
      }
      low = Math.min(low, series.low[i] ?? 0);
      high = Math.max(high, series.high[i] ?? 0);
    }
    flush();
    context.strokeStyle = colour;
    context.lineWidth = 1.25;
    context.lineJoin = "round";
    context.stroke();
  }
}

function rangeOf(series: Series): { low: number; high: number } {
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < series.length; i++) {
    low = Math.min(low, series.low[i] ?? low);
    high = Math.max(high, series.high[i] ?? high);
  }
  if (!(low <= high)) return { low: 0, high: 1 };
  // A figure that begins near zero is shown from zero.
  if (low > 0 && low < 0.5 * high) low = 0;
  if (low === high)
    return { low: low - Math.abs(low) * 0.1 - 1e-6, high: high + Math.abs(high) * 0.1 + 1e-6 };
  return { low, high };
}
