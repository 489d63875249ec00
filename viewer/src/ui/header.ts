import type { App } from "../app.ts";
import { kPalettes } from "../colours.ts";
import { kThemeChoices, themeOf } from "../settings.ts";
import { trackingWords } from "../words.ts";
import { icon, need, setText } from "./dom.ts";

const kModes = { replay: "replay", mapping: "mapping", localizing: "localising", "": "" };

/** The bar on top: what runs, how it goes, and the theme. */
export class Header {
  private readonly theme = need<HTMLButtonElement>("theme");
  private readonly dark = window.matchMedia("(prefers-color-scheme: dark)");
  private said = "";

  constructor(private readonly app: App) {
    this.theme.addEventListener("click", () => this.nextTheme());
    this.dark.addEventListener("change", () => this.applyTheme());
    need("screenshot").replaceChildren(icon("camera"));
    need("help-open").replaceChildren(icon("help"));
    need("drawer").replaceChildren(icon("panels"));
    app.watch(["about", "reset"], () => this.showRun());
    app.watch(["status", "reset"], () => this.showTracking());
  }

  nextTheme(): void {
    const { settings } = this.app;
    const at = kThemeChoices.indexOf(settings.theme);
    settings.theme = kThemeChoices[(at + 1) % kThemeChoices.length] ?? "system";
    settings.save();
    this.applyTheme();
    this.app.announce(`Theme: ${settings.theme}.`);
  }

  applyTheme(): void {
    const { app } = this;
    const { theme } = app.settings;
    app.theme = themeOf(theme, this.dark.matches);
    document.documentElement.dataset["theme"] = app.theme;
    this.theme.replaceChildren(icon({ system: "system", dark: "moon", light: "sun" }[theme]));
    const words = `Theme: ${theme === "system" ? "as the system" : theme}`;
    this.theme.title = `${words} (T)`;
    this.theme.setAttribute("aria-label", words);
    app.map.setPalette(kPalettes[app.theme]);
    app.chosen();
  }

  private showRun(): void {
    const { about } = this.app.model;
    const name = about?.name ?? "";
    setText(need("run"), name);
    need("run").title = name;
    const mode = need("mode");
    setText(mode, about ? kModes[about.mode] : "");
    mode.hidden = mode.textContent === "";
    document.title = name ? `${name} – Loopstone` : "Loopstone";
  }

  private showTracking(): void {
    const chip = need("tracking");
    const status = this.app.model.status?.status ?? "";
    chip.hidden = status === "";
    if (status === "" || status === this.said) return;
    const { label, mood, meaning } = trackingWords(status);
    setText(chip, label);
    chip.className = `chip state ${mood}`;
    chip.title = meaning;
    if (this.said !== "") this.app.announce(`${label}. ${meaning}`);
    this.said = status;
  }
}
