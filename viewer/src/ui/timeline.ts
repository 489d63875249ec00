import type { App } from "../app.ts";
import { clock, grouped, metres, optional, significant } from "../format.ts";
import { trackingWords } from "../words.ts";
import { h, icon, iconButton, setText } from "./dom.ts";

const kSpeeds = [0.25, 0.5, 1, 2, 5, 10, 20, 50, 100, 0];
/** One step where no key scan tells where the next is [s]. */
const kStep = 0.1;
const kSteps = 10_000;

/** The player, where there is anything to play, and the status line. */
export class Timeline {
  private readonly player = h("div", {
    class: "player",
    role: "group",
    "aria-label": "Player",
    hidden: true,
  });
  private readonly status = h("div", { class: "status", id: "status", tabindex: -1 });
  private readonly playButton: HTMLButtonElement;
  private readonly slider = h("input", {
    type: "range",
    id: "slider",
    min: 0,
    max: kSteps,
    step: 1,
    value: 0,
    "aria-label": "Time",
  });
  private readonly clock = h("span", { class: "clock", id: "clock" });
  private readonly speed = h("select", { id: "speed", "aria-label": "Speed", title: "Speed" });
  private readonly words = new Map<string, HTMLElement>();
  private dragging = false;
  private lastStatus = "";

  constructor(
    host: HTMLElement,
    private readonly app: App,
  ) {
    const step = (by: 1 | -1) => () => this.step(by);
    this.playButton = iconButton("play", "Play", "Space", () => this.toggle());
    this.playButton.id = "play";
    const back = iconButton("back", "Step back", "←", step(-1));
    const forward = iconButton("forward", "Step forward", "→", step(1));
    back.id = "step-back";
    forward.id = "step-forward";
    for (const speed of kSpeeds) {
      this.speed.append(h("option", { value: speed }, speed === 0 ? "fastest" : `× ${speed}`));
    }
    this.speed.addEventListener("change", () => app.session.setSpeed(Number(this.speed.value)));
    this.slider.addEventListener("input", () => {
      this.dragging = true;
      app.session.seek(this.timeOf(Number(this.slider.value)));
    });
    this.slider.addEventListener("change", () => (this.dragging = false));
    this.slider.addEventListener("keydown", (event) => this.sliderKey(event));
    this.player.append(back, this.playButton, forward, this.slider, this.clock, this.speed);
    host.append(this.player, this.status);
    app.watch(["playback", "reset"], () => this.showPlayer());
    app.watch(["time", "playback"], () => this.showTime());
    app.watch(["status", "time", "about", "reset"], () => this.showStatus());
  }

  private timeOf(value: number): number {
    const { start, end } = this.app.model;
    return (start ?? 0) + (value / kSteps) * ((end ?? 0) - (start ?? 0));
  }

  toggle(): void {
    if (this.app.model.canSeek) this.app.session.play(!this.app.session.playing);
  }

  step(by: 1 | -1): void {
    const { model, session } = this.app;
    if (!model.canSeek || model.time === null) return;
    if (session.playing) session.play(false);
    session.seek(model.track.neighbour(model.time, by) ?? model.time + by * kStep);
  }

  jump(seconds: number): void {
    const { model, session } = this.app;
    if (model.canSeek && model.time !== null) session.seek(model.time + seconds);
  }

  /** Twice or half as fast. */
  faster(by: 1 | -1): void {
    const { model, session } = this.app;
    if (!model.canSeek) return;
    const fixed = kSpeeds.filter((speed) => speed > 0);
    const at = fixed.findIndex((speed) => speed >= model.speed - 1e-6);
    const next = fixed[Math.min(fixed.length - 1, Math.max(0, (at < 0 ? fixed.length : at) + by))];
    if (next !== undefined) session.setSpeed(next);
  }

  private sliderKey(event: KeyboardEvent): void {
    const actions: Record<string, () => void> = {
      ArrowLeft: () => (event.shiftKey ? this.jump(-10) : this.step(-1)),
      ArrowRight: () => (event.shiftKey ? this.jump(10) : this.step(1)),
      ArrowDown: () => this.step(-1),
      ArrowUp: () => this.step(1),
      PageDown: () => this.jump(-60),
      PageUp: () => this.jump(60),
    };
    const action = actions[event.key];
    if (action === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    action();
  }

  private showPlayer(): void {
    const { model, session } = this.app;
    this.player.hidden = !model.canSeek;
    if (!model.canSeek) return;
    const { playing } = session;
    const label = playing ? "Pause" : model.playback === "ended" ? "Play again" : "Play";
    if (this.playButton.getAttribute("aria-label") !== label) {
      this.playButton.setAttribute("aria-label", label);
      this.playButton.title = `${label} (Space)`;
      this.playButton.replaceChildren(icon(playing ? "pause" : "play"));
    }
    this.showSpeed();
    if (model.playback !== this.lastStatus && this.lastStatus !== "") {
      if (model.playback === "ended") this.app.announce("The end is reached.");
      if (model.playback === "paused") this.app.announce("Paused.");
    }
    this.lastStatus = model.playback;
  }

  private showSpeed(): void {
    const { speed } = this.app.model;
    // Very large is as fast as it goes, too.
    const shown = speed === 0 || speed > 1000 ? 0 : Math.round(speed * 1000) / 1000;
    const options = [...this.speed.options];
    if (!options.some((option) => Number(option.value) === shown)) {
      this.speed.append(h("option", { value: shown }, `× ${shown}`));
    }
    if (document.activeElement !== this.speed) this.speed.value = String(shown);
  }

  private showTime(): void {
    const { start, end, time, canSeek } = this.app.model;
    if (!canSeek || start === null || end === null || time === null) return;
    const share = end > start ? (time - start) / (end - start) : 0;
    if (!this.dragging || document.activeElement !== this.slider) {
      this.slider.value = String(Math.round(share * kSteps));
    }
    const now = clock(time - start, 1);
    setText(this.clock, `${now} / ${clock(end - start)}`);
    this.slider.setAttribute("aria-valuetext", `${now} of ${clock(end - start)}`);
  }

  private showStatus(): void {
    const { status, time, about, canSeek } = this.app.model;
    const start = this.app.startTime;
    const t = status?.t ?? time;
    const entries: [string, string][] = [
      ["state", status?.status ? trackingWords(status.status).label : ""],
      ["time", !canSeek && t !== null ? clock(t - start) : ""],
      ["scans", optional(status?.scans ?? null, grouped)],
      ["travelled", optional(status?.travelled ?? null, metres)],
      ["real time", optional(status?.realtime || null, (value) => `× ${significant(value)}`)],
      ["memory", optional(status?.memory ?? null, (value) => `${grouped(value)} MB`)],
      ["loopstone", about?.version ?? ""],
    ];
    for (const [name, text] of entries) {
      let value = this.words.get(name);
      if (value === undefined) {
        value = h("b");
        this.words.set(name, value);
        this.status.append(h("span", {}, `${name} `, value));
      }
      setText(value, text);
      if (value.parentElement) value.parentElement.hidden = text === "" || text === "–";
    }
  }
}
