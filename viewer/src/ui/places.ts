import type { App } from "../app.ts";
import { Filled, h, need } from "./dom.ts";

const kMost = 100;

/** The verdict's places as buttons on the map. */
export class Places {
  private buttons: HTMLButtonElement[] = [];
  private readonly filled: Filled;

  constructor(
    private readonly host: HTMLElement,
    private readonly app: App,
  ) {
    this.filled = new Filled(host);
    app.watch(["verdict", "reset"], () => this.make());
    app.onChosen(() => this.move());
    // The wheel is the map's, also where a marker is in its way.
    host.addEventListener("wheel", (event) => {
      event.preventDefault();
      need("overlay").dispatchEvent(new WheelEvent("wheel", event));
    });
  }

  private make(): void {
    const { verdict } = this.app.model;
    const bad = verdict?.verdict === "bad";
    const places = (verdict?.places ?? []).slice(0, kMost);
    this.filled.show([places, bad], () => {
      this.buttons = places.map((place, i) => {
        const words = `Place ${i + 1}: ${place.text}`;
        const attributes = {
          type: "button",
          class: bad ? "place bad" : "place",
          title: words,
          "aria-label": words,
          onclick: () => this.app.map.goTo(place, 20),
        };
        return h("button", attributes, String(i + 1));
      });
      return this.buttons;
    });
    this.move();
  }

  /** Its lower left corner points to the place. */
  move(): void {
    const { app } = this;
    const places = app.model.verdict?.places ?? [];
    this.host.hidden = !app.settings.layers.places;
    this.buttons.forEach((button, i) => {
      const place = places[i];
      if (place === undefined) return;
      const { x, y } = app.map.camera.toScreen(place);
      const { width, height } = app.map.camera;
      const seen = x > -24 && y > 0 && x < width && y < height + 24;
      button.style.transform = `translate(${x.toFixed(1)}px, ${(y - 24).toFixed(1)}px)`;
      button.style.visibility = seen ? "" : "hidden";
    });
  }
}
