import type { App } from "../app.ts";
import type { Point } from "../geometry.ts";
import { h, iconButton, need, setText } from "./dom.ts";

/** The buttons on the map, what is measured, and where the pointer is. */
export class MapTools {
  private readonly fit: HTMLButtonElement;
  private readonly follow: HTMLButtonElement;
  private readonly measure: HTMLButtonElement;
  private readonly north: HTMLButtonElement;
  private readonly words = need("measure-words");
  private readonly readout = need("readout");
  private readonly text = h("span", { "aria-live": "polite" });

  constructor(private readonly app: App) {
    const { map } = app;
    this.fit = iconButton("fit", "Fit the whole map", "F", () => this.setFit());
    this.follow = iconButton("follow", "Follow the robot", "R", () => this.toggleFollow());
    this.measure = iconButton("measure", "Measure", "M", () => this.toggleMeasure());
    this.north = iconButton("north", "North up", "0", () => map.northUp());
    const named: [HTMLButtonElement, string][] = [
      [this.fit, "tool-fit"],
      [this.follow, "tool-follow"],
      [iconButton("plus", "Zoom in", "+", () => map.zoomMiddle(1.5)), "tool-in"],
      [iconButton("minus", "Zoom out", "-", () => map.zoomMiddle(1 / 1.5)), "tool-out"],
      [this.north, "tool-north"],
      [this.measure, "tool-measure"],
    ];
    const host = need("tools");
    named.forEach(([button, id], i) => {
      button.id = id;
      if (i === 2 || i === 5) host.append(h("hr"));
      host.append(button);
    });
    this.words.append(
      this.text,
      iconButton("close", "End measuring", "Esc", () => this.toggleMeasure()),
    );
    this.show();
  }

  setFit(): void {
    this.app.map.setMode("fit");
    this.show();
  }

  toggleFollow(): void {
    const { map } = this.app;
    map.setMode(map.mode === "follow" ? "free" : "follow");
    this.show();
  }

  toggleMeasure(): void {
    const { map, editor } = this.app;
    editor.cancel();
    map.measure.active = !map.measure.active;
    map.measure.clear();
    map.hover(null);
    map.redraw();
    this.showMeasure();
  }

  showMeasure(): void {
    const { measure } = this.app.map;
    this.words.hidden = !measure.active;
    setText(this.text, measure.active ? measure.describe() : "");
    this.measure.setAttribute("aria-pressed", String(measure.active));
  }

  point(at: Point | null): void {
    setText(this.readout, at === null ? "" : `x ${at.x.toFixed(2)}  y ${at.y.toFixed(2)} m`);
  }

  /** After each picture. */
  show(): void {
    const { map } = this.app;
    const press = (button: HTMLElement, pressed: boolean) => {
      if (button.getAttribute("aria-pressed") !== String(pressed)) {
        button.setAttribute("aria-pressed", String(pressed));
      }
    };
    press(this.fit, map.mode === "fit");
    press(this.follow, map.mode === "follow");
    press(this.measure, map.measure.active);
    const needle = this.north.firstElementChild;
    if (needle instanceof SVGElement) needle.style.rotate = `${-map.camera.angle}rad`;
  }
}
