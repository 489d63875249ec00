/** Colours of the map in both themes. Those of the page around it are in style.css. */
import type { PolygonKind } from "./edit_toml.ts";
import type { ClosureState } from "./json_messages.ts";

/** 0..1 each. */
export type Colour = readonly [number, number, number];

export function colourOf(hex: string): Colour {
  const value = Number.parseInt(hex.slice(1), 16);
  return [((value >> 16) & 255) / 255, ((value >> 8) & 255) / 255, (value & 255) / 255];
}

export type ThemeName = "dark" | "light";

export interface Palette {
  unknown: Colour;
  free: Colour;
  occupied: Colour;
  grid: Colour;
  scan: Colour;
  particles: Colour;
  ink: string;
  halo: string;
  robot: string;
  robotEdge: string;
  accent: string;
  closures: Record<ClosureState, string>;
  submaps: Record<"open" | "frozen" | "dropped", string>;
  edits: Record<PolygonKind, string>;
  ramp: string[];
  drives: string[];
}

export const kPalettes: Record<ThemeName, Palette> = {
  dark: {
    unknown: colourOf("#10151c"),
    free: colourOf("#26303c"),
    occupied: colourOf("#eef3f8"),
    grid: colourOf("#3d4a5a"),
    scan: colourOf("#ff7a59"),
    particles: colourOf("#ffd166"),
    ink: "#e6ebf2",
    halo: "#10151c",
    robot: "#ffffff",
    robotEdge: "#0b5cad",
    accent: "#7ab0ff",
    closures: { standing: "#34d399", waiting: "#fbbf24", rejected: "#ff6b9d", revoked: "#c4a5ff" },
    submaps: { open: "#7ab0ff", frozen: "#75859a", dropped: "#ff6b9d" },
    edits: { crop: "#7ab0ff", erase: "#c4a5ff", keep_out: "#ff6b9d", speed: "#fbbf24" },
    ramp: ["#3b6fd8", "#35b0d6", "#5fd3a2", "#d5df5a", "#ffb347"],
    drives: ["#56b4e9", "#e69f00", "#2cc79a", "#f0e442", "#e78ac3", "#ff8c5a", "#b5a7ff"],
  },
  light: {
    unknown: colourOf("#dfe4eb"),
    free: colourOf("#ffffff"),
    occupied: colourOf("#1b2530"),
    grid: colourOf("#b4bfcc"),
    scan: colourOf("#d9380b"),
    particles: colourOf("#9a5b00"),
    ink: "#17202b",
    halo: "#ffffff",
    robot: "#0b5cad",
    robotEdge: "#ffffff",
    accent: "#1756c4",
    closures: { standing: "#08805b", waiting: "#b45309", rejected: "#b0004e", revoked: "#6d28d9" },
    submaps: { open: "#1756c4", frozen: "#8592a3", dropped: "#b0004e" },
    edits: { crop: "#1756c4", erase: "#6d28d9", keep_out: "#b0004e", speed: "#9a5b00" },
    ramp: ["#1d3fb8", "#7a2fb5", "#c0278f", "#e0563b", "#e8960c"],
    drives: ["#0072b2", "#d55e00", "#00805c", "#8a6d00", "#b0407f", "#5b3fc4", "#4b5563"],
  },
};

/** A table of colours along a ramp, three bytes each. */
export function rampTable(stops: string[], size = 256): Uint8Array {
  const colours = stops.map(colourOf);
  const table = new Uint8Array(3 * size);
  for (let i = 0; i < size; i++) {
    const at = (i / (size - 1)) * (colours.length - 1);
    const below = Math.min(colours.length - 2, Math.floor(at));
    for (let k = 0; k < 3; k++) {
      const a = colours[below]?.[k] ?? 0;
      const b = colours[below + 1]?.[k] ?? 0;
      table[3 * i + k] = Math.round(255 * (a + (b - a) * (at - below)));
    }
  }
  return table;
}
