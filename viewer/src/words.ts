/** What the states of the program mean, in plain words. */
import { type PolygonKind, valueIn } from "./edit_toml.ts";
import type { ClosureFigures, Edit, Shift } from "./edits.ts";
import { metres, optional, percent, significant } from "./format.ts";
import type { ClosureState } from "./json_messages.ts";

export type Mood = "good" | "doubt" | "bad";

export interface StateWords {
  label: string;
  mood: Mood;
  meaning: string;
}

const kTracking: Record<string, StateWords> = {
  tracked: { label: "tracked", mood: "good", meaning: "The laser holds the robot's pose." },
  degenerate: {
    label: "degenerate",
    mood: "doubt",
    meaning: "The laser leaves one direction open, as in a corridor; odometry holds that one.",
  },
  bridged: {
    label: "bridged",
    mood: "doubt",
    meaning: "The laser says nothing here; odometry or the motion so far holds the pose.",
  },
  lost: {
    label: "lost",
    mood: "bad",
    meaning: "Nothing holds the pose: scans contradict the map, or there are none.",
  },
  TRACKING: {
    label: "TRACKING",
    mood: "good",
    meaning: "The pose is probably right, and there is no second place like it.",
  },
  DOUBTFUL: {
    label: "DOUBTFUL",
    mood: "doubt",
    meaning: "The pose may be right; or another place looks the same, or scans fit badly.",
  },
  LOST: {
    label: "LOST",
    mood: "bad",
    meaning: "The pose is wrong, or there is none yet; the map is searched.",
  },
};

export function trackingWords(status: string): StateWords {
  return kTracking[status] ?? { label: status, mood: "doubt", meaning: "" };
}

export const kVerdicts = {
  good: { label: "Good", mood: "good" },
  doubtful: { label: "Doubtful", mood: "doubt" },
  bad: { label: "Bad", mood: "bad" },
} as const;

export const kClosureWords: Record<
  ClosureState,
  { label: string; meaning: string; dash: string; mark: string }
> = {
  standing: {
    label: "standing",
    meaning: "Both scans agree and no other place fits as well; the graph uses it.",
    dash: "",
    mark: "disc",
  },
  waiting: {
    label: "waiting",
    meaning: "Plausible, but not yet sure enough to be used.",
    dash: "2 3.5",
    mark: "ring",
  },
  rejected: {
    label: "rejected",
    meaning: "Looked at and not accepted.",
    dash: "6 4",
    mark: "cross",
  },
  revoked: {
    label: "revoked",
    meaning: "Was accepted, then disproved by the rest.",
    dash: "7 3 2 3",
    mark: "diamond",
  },
};

/** Names of figures as they are plotted; others are shown as they come. */
const kFigures: Record<string, string> = {
  sigma_m: "uncertainty of position [m]",
  front_end_ms: "time a scan takes [ms]",
  probability: "probability of being right",
  realtime: "times real time",
  memory_mb: "memory [MB]",
};

export function figureLabel(name: string): string {
  const known = kFigures[name];
  if (known !== undefined) return known;
  const unit = /_(m|ms|s|deg|rad|mb|m2|percent)$/.exec(name)?.[1];
  const words = (unit ? name.slice(0, -unit.length - 1) : name).replaceAll("_", " ");
  return unit ? `${words} [${{ mb: "MB", m2: "m²", percent: "%" }[unit] ?? unit}]` : words;
}

/** Kinds of edits; what is not known is shown as it comes. */
const kEdits: Record<string, string> = {
  delete_closure: "Closure deleted",
  add_closure: "Closure added",
  ignore: "Stretch ignored",
  crop: "Cropped",
  erase: "Erased",
  straighten: "Straightened",
  origin: "Origin set",
  keep_out: "Keep-out zone",
  speed: "Speed zone",
};

/** With its name, where it has one. */
export function editWords({ kind, toml }: Pick<Edit, "kind" | "toml">): string {
  const words = kEdits[kind] ?? (kind.replaceAll("_", " ") || "Edit");
  const name = valueIn(toml, "name");
  return name ? `${words} “${name}”` : words;
}

const kZones: Record<PolygonKind, string> = {
  crop: "crop",
  erase: "erased",
  keep_out: "keep out",
  speed: "slow",
};

/** What is written on the map: the name, and how fast. */
export function zoneName(kind: PolygonKind, toml: string): string {
  const name = valueIn(toml, "name") || kZones[kind];
  const share = valueIn(toml, "percent");
  const limit = valueIn(toml, "limit_m_s");
  if (kind !== "speed" || (share === null && limit === null)) return name;
  return `${name}: ${share !== null ? `${share} %` : `${limit} m/s`}`;
}

const kStill = 0.0005;

export function shiftWords(shift: Shift | null): string {
  if (shift === null) return "";
  const degrees = (shift.turned * 180) / Math.PI;
  if (shift.largest < kStill && degrees < 0.005) return "Nothing moved.";
  const turned = degrees >= 0.005 ? `, turned by up to ${significant(degrees, 2)}°` : "";
  return `Moved by up to ${metres(shift.largest)}, ${metres(shift.mean)} on average${turned}.`;
}

export function figureWords(figures: ClosureFigures): string {
  const entries: [string, string][] = [
    ["score", optional(figures.score, significant)],
    ["second score", optional(figures.secondScore, significant)],
    ["overlap", optional(figures.overlap, percent)],
    ["agreement", optional(figures.agreement, percent)],
    ["χ²", optional(figures.chi2, significant)],
  ];
  const known = entries.filter(([, text]) => text !== "–");
  return known.map(([name, text]) => `${name} ${text}`).join(", ");
}
