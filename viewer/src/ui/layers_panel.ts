import type { App } from "../app.ts";
import { rampTable } from "../colours.ts";
import { rangeOfPath } from "../fills.ts";
import { clock, metres } from "../format.ts";
import { kPathColours, type Layer, type PathColour } from "../settings.ts";
import { kSubmapStates } from "../json_messages.ts";
import { h, swatch } from "./dom.ts";

interface Row {
  layer: Layer;
  label: string;
  opacity?: "map" | "quality" | "texture";
  /** Colour of the palette and how it looks. */
  look?: (app: App) => SVGSVGElement;
  /** Whether there is anything to show. */
  there?: (app: App) => boolean;
  /** Whether there could be: else the row is hidden. */
  offered?: (app: App) => boolean;
}

const hexOf = (colour: readonly [number, number, number]) =>
  `rgb(${colour.map((share) => Math.round(255 * share)).join(" ")})`;

const kRows: Row[] = [
  { layer: "map", label: "map", opacity: "map" },
  {
    layer: "texture",
    label: "floor in colour",
    opacity: "texture",
    there: (app) => app.model.texture !== null,
  },
  {
    layer: "quality",
    label: "quality",
    opacity: "quality",
    there: (app) => app.model.quality !== null,
  },
  { layer: "grid", label: "grid" },
  {
    layer: "robot",
    label: "robot, with 95 % ellipse",
    look: (app) =>
      swatch(
        app.palette.robot === "#ffffff" ? app.palette.accent : app.palette.robot,
        "none",
        "arrow",
      ),
  },
  { layer: "scan", label: "scan", look: (app) => swatch(hexOf(app.palette.scan), "none", "dots") },
  {
    layer: "particles",
    label: "particles",
    look: (app) => swatch(hexOf(app.palette.particles), "none", "arrow"),
    there: (app) => app.model.particles.length > 0,
  },
  {
    layer: "places",
    label: "places of the verdict",
    there: (app) => (app.model.verdict?.places.length ?? 0) > 0,
  },
  {
    layer: "submaps",
    label: "submaps' outlines",
    look: (app) => swatch(app.palette.submaps.frozen, "none", "box"),
    there: (app) => app.model.submaps.length > 0,
  },
  {
    layer: "closures",
    label: "loop closures",
    look: (app) => swatch(app.palette.closures.standing, "", "disc"),
  },
  {
    layer: "edits",
    label: "edits: zones and polygons",
    look: (app) => swatch(app.palette.edits.keep_out, "none", "box"),
    offered: (app) => app.model.about?.canEdit ?? false,
  },
  { layer: "path", label: "path", look: (app) => swatch(app.palette.ramp[2] ?? "", "", "") },
];

/** What is drawn, how strongly, and in which colours. */
export class LayersPanel {
  readonly panel = h("div");
  private readonly rampCanvas = h("canvas", { width: 256, height: 1, "aria-hidden": "true" });
  private readonly low = h("span");
  private readonly high = h("span");
  private readonly ramp = h(
    "div",
    { class: "ramp" },
    this.rampCanvas,
    h("div", {}, this.low, this.high),
  );
  private readonly drives = h("p", { class: "small soft" });

  constructor(private readonly app: App) {
    const layers = h("fieldset", { class: "block" }, h("legend", {}, "Layers"));
    for (const row of kRows) layers.append(this.row(row));
    const path = h("fieldset", { class: "block" }, h("legend", {}, "Colour of the path"));
    path.append(this.pathChoice(), this.ramp, this.drives);
    const submaps = h("p", { class: "small soft" });
    this.panel.append(layers, path, h("section", { class: "block" }, submaps));
    app.watch(["trajectory", "reset"], () => this.showRamp());
    app.onChosen(() => this.showRamp());
    app.watch(["submaps", "reset"], () => {
      const counts = kSubmapStates.map((state) => {
        const count = app.model.submaps.filter((one) => one.state === state).length;
        return `${count} ${state}`;
      });
      submaps.textContent = app.model.submaps.length > 0 ? `Submaps: ${counts.join(", ")}.` : "";
    });
  }

  private row({ layer, label, opacity, look, there, offered }: Row): HTMLElement {
    const { app } = this;
    const box = h("input", {
      type: "checkbox",
      id: `layer-${layer}`,
      checked: app.settings.layers[layer],
      onchange: () => {
        app.settings.layers[layer] = box.checked;
        app.chosen();
      },
    });
    const words = h("label", {}, box, label);
    const line = h("div", { class: "row" }, words);
    if (opacity !== undefined) line.append(this.slider(opacity, label));
    if (look !== undefined) {
      let shown = look(app);
      line.append(shown);
      app.onChosen(() => {
        const next = look(app);
        shown.replaceWith(next);
        shown = next;
      });
    }
    app.onChosen(() => (box.checked = app.settings.layers[layer]));
    if (there !== undefined) {
      const show = () => words.classList.toggle("off", !there(app));
      app.watch(["quality", "texture", "particles", "verdict", "submaps", "reset"], show);
    }
    if (offered !== undefined) {
      app.watch(["about", "reset"], () => (line.hidden = !offered(app)));
      line.hidden = true;
    }
    return line;
  }

  private slider(name: "map" | "quality" | "texture", label: string): HTMLElement {
    const { app } = this;
    const slider = h("input", {
      type: "range",
      id: `opacity-${name}`,
      min: 0,
      max: 100,
      step: 5,
      value: app.settings.opacity[name] * 100,
      "aria-label": `Opacity of ${label}`,
      title: "opacity",
      oninput: () => {
        app.settings.opacity[name] = Number(slider.value) / 100;
        app.chosen();
      },
    });
    return slider;
  }

  private pathChoice(): HTMLElement {
    const one = (value: PathColour) =>
      h(
        "label",
        {},
        h("input", {
          type: "radio",
          name: "path-colour",
          value,
          checked: this.app.settings.pathColour === value,
          onchange: () => {
            this.app.settings.pathColour = value;
            this.app.chosen();
          },
        }),
        value,
      );
    const attributes = { class: "choice", role: "radiogroup", "aria-label": "Colour of the path" };
    return h("div", attributes, ...kPathColours.map(one));
  }

  private showRamp(): void {
    const { app, rampCanvas } = this;
    const by = app.settings.pathColour;
    const [low, high] = rangeOfPath(app.model.track, by);
    this.ramp.hidden = by === "drive" || app.model.track.length === 0;
    this.drives.textContent = "";
    if (by === "drive") {
      const drives = new Set(app.model.track.drives.subarray(0, app.model.track.length));
      this.drives.textContent = `${drives.size} ${drives.size === 1 ? "drive" : "drives"}, a colour each.`;
      return;
    }
    this.low.textContent = by === "time" ? clock(low - app.startTime) : "σ 0";
    this.high.textContent = by === "time" ? clock(high - app.startTime) : `σ ${metres(high)}`;
    const table = rampTable(app.palette.ramp);
    const image = new ImageData(256, 1);
    for (let i = 0; i < 256; i++) {
      image.data.set([table[3 * i] ?? 0, table[3 * i + 1] ?? 0, table[3 * i + 2] ?? 0, 255], 4 * i);
    }
    rampCanvas.getContext("2d")?.putImageData(image, 0, 0);
  }
}
