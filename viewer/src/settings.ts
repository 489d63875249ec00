/** What the reader chose, remembered by the browser where it lets us. */
import type { ThemeName } from "./colours.ts";
import { type ClosureState, kClosureStates } from "./json_messages.ts";
import { isObject, numberOf, parseObject, wordOf } from "./json.ts";

export const kLayers = [
  "map",
  "grid",
  "quality",
  "texture",
  "submaps",
  "path",
  "closures",
  "scan",
  "particles",
  "robot",
  "places",
  "edits",
] as const;
export type Layer = (typeof kLayers)[number];

export const kPathColours = ["time", "uncertainty", "drive"] as const;
export type PathColour = (typeof kPathColours)[number];

export const kThemeChoices = ["system", "dark", "light"] as const;
export type ThemeChoice = (typeof kThemeChoices)[number];

const kKey = "loopstone.view";

export class Settings {
  theme: ThemeChoice = "system";
  readonly layers: Record<Layer, boolean> = {
    map: true,
    grid: true,
    quality: false,
    texture: true,
    submaps: false,
    path: true,
    closures: true,
    scan: true,
    particles: true,
    robot: true,
    places: true,
    edits: true,
  };
  /** 0..1 */
  readonly opacity: Record<"map" | "quality" | "texture", number> = {
    map: 1,
    quality: 0.7,
    texture: 0.8,
  };
  readonly closures: Record<ClosureState, boolean> = {
    standing: true,
    waiting: true,
    rejected: false,
    revoked: true,
  };
  pathColour: PathColour = "time";
  /** Names of the figures that are plotted; null until the reader has chosen. */
  plots: string[] | null = null;

  constructor(private readonly storage: Pick<Storage, "getItem" | "setItem"> | null) {
    this.load();
  }

  private load(): void {
    let text: string | null = null;
    try {
      text = this.storage?.getItem(kKey) ?? null;
    } catch {
      return;
    }
    const json = text === null ? null : parseObject(text);
    if (json === null) return;
    this.theme = wordOf(json["theme"], kThemeChoices);
    this.pathColour = wordOf(json["pathColour"], kPathColours);
    copySwitches(json["layers"], this.layers, kLayers);
    copySwitches(json["closures"], this.closures, kClosureStates);
    const opacity = json["opacity"];
    if (isObject(opacity)) {
      for (const name of ["map", "quality", "texture"] as const) {
        const value = numberOf(opacity[name]);
        if (value !== null) this.opacity[name] = Math.min(1, Math.max(0, value));
      }
    }
    const plots = json["plots"];
    if (Array.isArray(plots)) this.plots = plots.filter((one) => typeof one === "string");
  }

  save(): void {
    const { theme, layers, opacity, closures, pathColour, plots } = this;
    try {
      const text = JSON.stringify({ theme, layers, opacity, closures, pathColour, plots });
      this.storage?.setItem(kKey, text);
    } catch {
      // A browser that keeps nothing: the choice holds until the page is closed.
    }
  }
}

function copySwitches<K extends string>(
  from: unknown,
  to: Record<K, boolean>,
  names: readonly K[],
): void {
  if (!isObject(from)) return;
  for (const name of names) {
    const value = from[name];
    if (typeof value === "boolean") to[name] = value;
  }
}

export function themeOf(choice: ThemeChoice, systemIsDark: boolean): ThemeName {
  return choice === "system" ? (systemIsDark ? "dark" : "light") : choice;
}
