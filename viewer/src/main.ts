/** Puts the page together. */
import { App } from "./app.ts";
import { EditClient, type EditSurroundings } from "./edit_client.ts";
import { Editor } from "./edit/editor.ts";
import { kPalettes } from "./colours.ts";
import { Frames } from "./frames.ts";
import { type MapListener, MapView } from "./map_view.ts";
import { Model } from "./model.ts";
import { Session, type Surroundings } from "./session.ts";
import { Settings } from "./settings.ts";
import { exposeState } from "./state.ts";
import { kSubProtocols } from "./protocol.ts";
import { ClosuresPanel } from "./ui/closures_panel.ts";
import { h, need } from "./ui/dom.ts";
import { EditPanel } from "./ui/edit_panel.ts";
import { EditWords } from "./ui/edit_words.ts";
import { Header } from "./ui/header.ts";
import { Help } from "./ui/help.ts";
import { listenToKeys } from "./ui/keys.ts";
import { LayersPanel } from "./ui/layers_panel.ts";
import { MapTools } from "./ui/map_tools.ts";
import { Notices } from "./ui/notices.ts";
import { Overview } from "./ui/overview.ts";
import { Places } from "./ui/places.ts";
import { PlotsPanel } from "./ui/plots_panel.ts";
import { Tabs } from "./ui/tabs.ts";
import { Timeline } from "./ui/timeline.ts";

const kBrowser: Surroundings = {
  open: (url) => new WebSocket(url, kSubProtocols),
  fetch: (url) => fetch(url),
  setTimeout: (task, milliseconds) => window.setTimeout(task, milliseconds),
  clearTimeout: (timer) => window.clearTimeout(timer),
  now: () => Date.now(),
  random: () => Math.random(),
};

const kForEdits: EditSurroundings = {
  fetch: (url, init) => fetch(url, init),
  setTimeout: (task, milliseconds) => window.setTimeout(task, milliseconds),
  clearTimeout: (timer) => window.clearTimeout(timer),
};

function storage(): Storage | null {
  try {
    return window.localStorage;
  } catch {
    return null;
  }
}

/** For those who do not see the page: one after the other, so that none is lost. */
function announce(text: string): void {
  const live = need("live");
  live.append(h("p", {}, text));
  while (live.childElementCount > 4) live.firstElementChild?.remove();
}

class Page {
  private readonly app: App;
  private readonly header: Header;
  private readonly tabs: Tabs;
  private readonly tools: MapTools;
  private readonly places: Places;
  private readonly timeline: Timeline;
  private readonly help: Help;
  private readonly closures: ClosuresPanel;
  private readonly plots: PlotsPanel;
  private readonly edits: EditPanel;
  private readonly side = need("side");
  private readonly drawer = need<HTMLButtonElement>("drawer");
  private toldVerdict = "";

  constructor() {
    const model = new Model();
    const settings = new Settings(storage());
    const frames = new Frames((task) => requestAnimationFrame(task));
    const session = new Session(model, window.location.href, kBrowser);
    this.app = new App(model, settings, session, frames, announce);
    const canvases = [need<HTMLCanvasElement>("map"), need<HTMLCanvasElement>("overlay")] as const;
    this.app.map = new MapView(...canvases, model, settings, kPalettes.dark, this.mapListener());
    this.app.editor = this.makeEditor();
    this.tools = new MapTools(this.app);
    this.places = new Places(need("places"), this.app);
    this.header = new Header(this.app);
    this.timeline = new Timeline(need("time"), this.app);
    this.help = new Help(this.app);
    this.closures = new ClosuresPanel(this.app);
    this.plots = new PlotsPanel(this.app);
    this.edits = new EditPanel(this.app, (what) => this.showFor(what));
    new EditWords(this.app, () => this.edits.toForm());
    this.tabs = this.makeTabs();
    new Notices(this.app);
    this.listen();
    this.header.applyTheme();
    exposeState(this.app, this.closures.detail, this.tabs);
    session.connect();
  }

  private makeEditor(): Editor {
    const { app } = this;
    const client = new EditClient(app.model, app.session.api, kForEdits, () =>
      app.editor.changed(),
    );
    return new Editor(app, client);
  }

  /** The map, which a drawer may cover, or the panel of edits. */
  private showFor(what: "map" | "panel"): void {
    if (what === "panel") this.tabs.show("edit");
    this.openDrawer(what === "panel");
  }

  private mapListener(): MapListener {
    return {
      moved: () => {
        this.places.move();
        this.tools.show();
      },
      picked: (closure) => {
        this.app.select(closure?.id ?? null);
        if (closure !== null) {
          this.tabs.show("closures");
          this.openDrawer(true);
        }
      },
      pointed: (at) => this.tools.point(at),
      measured: () => this.tools.showMeasure(),
      contextRestored: () => {
        this.app.session.askAgain("/loopstone/tiles");
        this.app.session.askAgain("/map");
      },
    };
  }

  private makeTabs(): Tabs {
    const { app } = this;
    const list = [
      { id: "overview", label: "Overview", panel: new Overview(app).panel },
      { id: "closures", label: "Closures", panel: this.closures.panel },
      { id: "layers", label: "Layers", panel: new LayersPanel(app).panel },
      { id: "plots", label: "Plots", panel: this.plots.panel },
      { id: "edit", label: "Edit", panel: this.edits.panel },
    ];
    const tabs = new Tabs(need("tabs"), need("panels"), list, (id) => {
      this.plots.visible = id === "plots";
      app.frames.request(this.plots.refresh);
    });
    tabs.setThere("edit", false);
    app.watch(["about", "reset"], () => tabs.setThere("edit", app.editor.allowed));
    app.watch(["closures", "reset"], () => tabs.setCount("closures", app.model.closures.length));
    return tabs;
  }

  private listen(): void {
    const { app } = this;
    need("screenshot").addEventListener("click", () => this.savePicture());
    need("help-open").addEventListener("click", () => this.help.toggle());
    this.drawer.addEventListener("click", () =>
      this.openDrawer(!this.side.classList.contains("open")),
    );
    // Who comes back to the page, or to a network, need not wait for the next try.
    const tryAgain = () => {
      const { state } = app.model.connection;
      if (!document.hidden && (state === "lost" || state === "refused")) app.session.connect();
    };
    window.addEventListener("online", tryAgain);
    document.addEventListener("visibilitychange", tryAgain);
    app.watch(["verdict"], () => {
      const { verdict } = app.model;
      const words = verdict?.sentence ? `Verdict: ${verdict.verdict}. ${verdict.sentence}` : "";
      if (words && words !== this.toldVerdict) app.announce(words);
      this.toldVerdict = words;
    });
    listenToKeys(this.keys(), () => this.help.open);
  }

  private keys(): Record<string, () => void> {
    const { app, timeline, tools, closures } = this;
    const tab = (id: string) => () => {
      if (!this.tabs.isThere(id)) return;
      this.tabs.show(id);
      this.openDrawer(true);
    };
    const { map, editor } = app;
    return {
      " ": () => timeline.toggle(),
      ArrowLeft: () => timeline.step(-1),
      ArrowRight: () => timeline.step(1),
      "Shift+ArrowLeft": () => timeline.jump(-10),
      "Shift+ArrowRight": () => timeline.jump(10),
      ",": () => timeline.step(-1),
      ".": () => timeline.step(1),
      "<": () => timeline.faster(-1),
      ">": () => timeline.faster(1),
      "+": () => map.zoomMiddle(1.5),
      "=": () => map.zoomMiddle(1.5),
      "-": () => map.zoomMiddle(1 / 1.5),
      "[": () => map.turn(map.turnStep),
      "]": () => map.turn(-map.turnStep),
      "0": () => map.northUp(),
      f: () => tools.setFit(),
      r: () => tools.toggleFollow(),
      m: () => tools.toggleMeasure(),
      g: () => {
        app.settings.layers.grid = !app.settings.layers.grid;
        app.chosen();
      },
      t: () => this.header.nextTheme(),
      p: () => this.savePicture(),
      n: () => closures.step(1),
      b: () => closures.step(-1),
      z: () => closures.detail.zoomTo(),
      v: () => closures.detail.toggle(),
      "1": tab("overview"),
      "2": tab("closures"),
      "3": tab("layers"),
      "4": tab("plots"),
      "5": tab("edit"),
      Delete: () => closures.detail.delete(),
      "Ctrl+z": () => void (editor.takeBack() || editor.undo()),
      "?": () => this.help.toggle(),
      Escape: () => this.escape(),
    };
  }

  /** Ends whatever was begun last. */
  private escape(): void {
    const { measure } = this.app.map;
    if (this.app.editor.tool !== null) this.app.editor.cancel();
    else if (this.app.editor.message.bad) this.app.editor.say("");
    else if (measure.active) this.tools.toggleMeasure();
    else if (this.app.selected !== null) this.app.select(null);
    else this.openDrawer(false);
  }

  private openDrawer(open: boolean): void {
    this.side.classList.toggle("open", open);
    this.drawer.setAttribute("aria-expanded", String(open));
    const covers = open && window.getComputedStyle(this.side).position === "fixed";
    const below = this.side.clientHeight - need("time").clientHeight;
    this.app.map.covered = covers ? Math.max(0, below) : 0;
    this.app.map.redraw();
  }

  private savePicture(): void {
    this.app.map.picture().toBlob((blob) => {
      if (blob === null) return;
      const url = URL.createObjectURL(blob);
      const name = (this.app.model.about?.name || "loopstone").replace(/[^\w.-]+/g, "_");
      h("a", { href: url, download: `${name}.png` }).click();
      window.setTimeout(() => URL.revokeObjectURL(url), 10_000);
      this.app.announce("The picture is saved.");
    }, "image/png");
  }
}

try {
  new Page();
} catch (error) {
  const notice = need("notice");
  const why = error instanceof Error ? error.message : String(error);
  notice.hidden = false;
  notice.replaceChildren(h("strong", {}, "The page cannot be shown"), h("p", {}, why));
  need("connection").textContent = "";
}
