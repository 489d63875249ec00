/** What the states of the program mean, in plain words. */
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
