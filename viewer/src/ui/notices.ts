import type { App } from "../app.ts";
import { isEmpty } from "../geometry.ts";
import { h, need, setText } from "./dom.ts";

/** What the page says when there is no map to see, or nobody to send one. */
export class Notices {
  private readonly notice = need("notice");
  private readonly banner = need("banner");
  private readonly connection = need("connection");
  private shown = "";
  private said = "";
  private timer = 0;

  constructor(private readonly app: App) {
    app.watch(["connection", "map", "trajectory", "pose", "about", "reset"], () => this.show());
  }

  private get anything(): boolean {
    const { map, model } = this.app;
    return !isEmpty(map.scene.extent()) || model.track.length > 0 || model.robot !== null;
  }

  private show(): void {
    const { connection } = this.app.model;
    window.clearTimeout(this.timer);
    const waiting = connection.state === "lost" || connection.state === "refused";
    if (waiting) this.timer = window.setTimeout(() => this.show(), 250);
    this.showState();
    if (this.anything) {
      this.showNotice("", () => []);
      this.showBanner(connection.state !== "open");
      return;
    }
    this.showBanner(false);
    // Between two tries what was said stays, with its button.
    const trying = connection.state === "connecting";
    if (trying && (this.shown === "lost" || this.shown === "refused")) return;
    if (connection.state === "connecting") {
      this.showNotice("connecting", () => [
        h("div", { class: "spinner" }),
        h("strong", {}, "Connecting …"),
      ]);
    } else if (connection.state === "open") {
      const words = "The map appears with the first scans.";
      this.showNotice("empty", () => [
        h("strong", {}, "Connected, nothing to see yet"),
        h("p", {}, words),
      ]);
    } else if (connection.state === "refused") {
      this.showNotice("refused", () => [
        h("strong", {}, connection.reason),
        h(
          "p",
          {},
          "Open the address that the program has printed, with everything after the question mark.",
        ),
        this.again(),
      ]);
    } else {
      this.showNotice("lost", () => [
        h("strong", {}, "No connection to the program"),
        h("p", {}, "It may have ended, or not have begun. The page goes on trying."),
        this.again(),
      ]);
    }
  }

  private again(): HTMLElement {
    const attributes = {
      type: "button",
      class: "plain",
      onclick: () => this.app.session.connect(),
    };
    return h("button", attributes, "Try now");
  }

  private showNotice(name: string, make: () => Node[]): void {
    if (name === this.shown) return;
    this.shown = name;
    this.notice.hidden = name === "";
    this.notice.dataset["name"] = name;
    this.notice.replaceChildren(...make());
  }

  private showBanner(lost: boolean): void {
    const { connection } = this.app.model;
    if (!lost) {
      this.banner.hidden = true;
      this.banner.replaceChildren();
      return;
    }
    if (this.banner.hidden) this.banner.replaceChildren(h("span"), this.again());
    this.banner.hidden = false;
    const why =
      connection.state === "refused"
        ? connection.reason
        : "Connection lost; this is what was known.";
    let next = "Trying again.";
    if ("retryAt" in connection) {
      const seconds = Math.max(0, Math.ceil((connection.retryAt - Date.now()) / 1000));
      next = `Next try in ${seconds} s.`;
    }
    const first = this.banner.firstElementChild;
    if (first instanceof HTMLElement) setText(first, `${why} ${next}`);
  }

  private showState(): void {
    const { connection } = this.app.model;
    const words = {
      connecting: ["connecting", "connection waiting doubt", "Connecting."],
      open: ["connected", "connection fine good", "Connected."],
      lost: [
        "connection lost",
        "connection waiting bad",
        "Connection lost. The page goes on trying.",
      ],
      refused: ["refused", "connection bad", "The server refuses this page."],
    }[connection.state];
    const [label = "", classes = "", spoken = ""] = words;
    setText(this.connection, label);
    this.connection.className = classes;
    // Attempts in between are not worth a word.
    if (connection.state !== "connecting" && spoken !== this.said) {
      this.said = spoken;
      this.app.announce(spoken);
    }
  }
}
