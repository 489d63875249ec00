/** The messages in JSON. Whatever text comes, a value of the right shape or null comes back. */
import type { Pose } from "./geometry.ts";
import { type Json, numberOf, numbersOf, objectsOf, parseObject, textOf, textsOf } from "./json.ts";
import { wordOf } from "./json.ts";

export const kClosureStates = ["standing", "waiting", "rejected", "revoked"] as const;
export type ClosureState = (typeof kClosureStates)[number];

export interface Closure {
  id: number;
  /** Nodes of the trajectory. */
  from: number;
  to: number;
  fromTime: number | null;
  toTime: number | null;
  fromSubmap: number | null;
  toSubmap: number | null;
  state: ClosureState;
  reason: string;
  score: number | null;
  secondScore: number | null;
  overlap: number | null;
  agreement: number | null;
  chi2: number | null;
  sigma: number | null;
  byAppearance: boolean;
}

export interface Status {
  t: number | null;
  status: string;
  scans: number | null;
  travelled: number | null;
  submaps: number | null;
  closures: number | null;
  rejected: number | null;
  mapArea: number | null;
  realtime: number | null;
  memory: number | null;
  figures: Map<string, number>;
}

export const kSubmapStates = ["open", "frozen", "dropped"] as const;

export interface Submap {
  id: number;
  state: (typeof kSubmapStates)[number];
  /** x and y in turn, in the map's frame. */
  outline: number[];
}

export interface Place {
  x: number;
  y: number;
  text: string;
}

export interface Verdict {
  verdict: "" | "good" | "doubtful" | "bad";
  sentence: string;
  reasons: string[];
  complete: boolean;
  places: Place[];
}

export interface Warning {
  t: number | null;
  text: string;
}

export interface Picture {
  x: number;
  y: number;
  resolution: number;
  png: string;
}

export interface About {
  version: string;
  mode: "" | "replay" | "mapping" | "localizing";
  name: string;
  canSeek: boolean;
  canEdit: boolean;
}

export interface Evidence {
  id: number;
  from: ScanOf;
  to: ScanOf;
  /** from_T_to, as registration measured it and as the graph has it. */
  measured: Pose;
  graph: Pose;
}

export interface ScanOf {
  t: number | null;
  /** x and y in turn, in the robot's frame at that time. */
  points: number[];
}

const kMostFigures = 64;

function closureOf(json: Json): Closure | null {
  const id = numberOf(json["id"]);
  const from = numberOf(json["from"]);
  const to = numberOf(json["to"]);
  if (id === null || from === null || to === null) return null;
  return {
    id,
    from,
    to,
    fromTime: numberOf(json["from_t"]),
    toTime: numberOf(json["to_t"]),
    fromSubmap: numberOf(json["from_submap"]),
    toSubmap: numberOf(json["to_submap"]),
    state: wordOf(json["state"], kClosureStates),
    reason: textOf(json["reason"]),
    score: numberOf(json["score"]),
    secondScore: numberOf(json["second_score"]),
    overlap: numberOf(json["overlap"]),
    agreement: numberOf(json["agreement"]),
    chi2: numberOf(json["chi2"]),
    sigma: numberOf(json["sigma_m"]),
    byAppearance: json["by_appearance"] === true,
  };
}

/** Of a list whose entries are named by their place: how many there are now, and those to be put. */
export interface ListChange<T> {
  count: number;
  entries: T[];
}

const kMostEntries = 1e6;

function readChange<T>(
  text: string,
  name: string,
  read: (json: Json) => T | null,
): ListChange<T> | null {
  const json = parseObject(text);
  const count = numberOf(json?.["count"]);
  if (json === null || count === null || !(count >= 0 && count <= kMostEntries)) return null;
  const entries = objectsOf(json[name])
    .map(read)
    .filter((one) => one !== null);
  return { count, entries };
}

export function readClosures(text: string): ListChange<Closure> | null {
  return readChange(text, "closures", closureOf);
}

function submapOf(json: Json): Submap | null {
  const id = numberOf(json["id"]);
  if (id === null) return null;
  return {
    id,
    state: wordOf(json["state"], kSubmapStates),
    outline: numbersOf(json["outline"]) ?? [],
  };
}

export function readStatus(text: string): Status | null {
  const json = parseObject(text);
  if (json === null) return null;
  const figures = new Map<string, number>();
  const given = objectsOf([json["figures"]])[0] ?? {};
  for (const [name, value] of Object.entries(given).slice(0, kMostFigures)) {
    const number = numberOf(value);
    if (number !== null) figures.set(name, number);
  }
  return {
    t: numberOf(json["t"]),
    status: textOf(json["status"]),
    scans: numberOf(json["scans"]),
    travelled: numberOf(json["travelled_m"]),
    submaps: numberOf(json["submaps"]),
    closures: numberOf(json["closures"]),
    rejected: numberOf(json["rejected"]),
    mapArea: numberOf(json["map_m2"]),
    realtime: numberOf(json["realtime"]),
    memory: numberOf(json["memory_mb"]),
    figures,
  };
}

export function readSubmaps(text: string): ListChange<Submap> | null {
  return readChange(text, "submaps", submapOf);
}

export function readVerdict(text: string): Verdict | null {
  const json = parseObject(text);
  if (json === null) return null;
  const places = objectsOf(json["places"]).map((one) => {
    const x = numberOf(one["x"]);
    const y = numberOf(one["y"]);
    return x === null || y === null ? null : { x, y, text: textOf(one["text"]) };
  });
  return {
    verdict: wordOf(json["verdict"], ["", "good", "doubtful", "bad"]),
    sentence: textOf(json["sentence"]),
    reasons: textsOf(json["reasons"]),
    complete: json["complete"] === true,
    places: places.filter((one) => one !== null),
  };
}

export function readWarnings(text: string): Warning[] | null {
  const json = parseObject(text);
  if (json === null) return null;
  return objectsOf(json["warnings"]).map((one) => ({
    t: numberOf(one["t"]),
    text: textOf(one["text"]),
  }));
}

/** Null of what is none; without a picture where there is none any more. */
export function readPicture(text: string): { picture: Picture | null } | null {
  const json = parseObject(text);
  if (json === null) return null;
  if (json["png"] === "") return { picture: null };
  const x = numberOf(json["x"]);
  const y = numberOf(json["y"]);
  const resolution = numberOf(json["resolution"]);
  const png = textOf(json["png"]);
  if (x === null || y === null || resolution === null || resolution <= 0 || !png) return null;
  return { picture: { x, y, resolution, png } };
}

export function readAbout(text: string): About | null {
  const json = parseObject(text);
  if (json === null) return null;
  return {
    version: textOf(json["version"]),
    mode: wordOf(json["mode"], ["", "replay", "mapping", "localizing"]),
    name: textOf(json["name"]),
    canSeek: json["can_seek"] === true,
    canEdit: json["can_edit"] === true,
  };
}

function poseOf(value: unknown): Pose | null {
  const [x, y, yaw] = numbersOf(value) ?? [];
  return x === undefined || y === undefined || yaw === undefined ? null : { x, y, yaw };
}

function scanOf(value: unknown): ScanOf {
  const json = objectsOf([value])[0] ?? {};
  return { t: numberOf(json["t"]), points: numbersOf(json["points"]) ?? [] };
}

export function readEvidence(text: string): Evidence | null {
  const json = parseObject(text);
  if (json === null) return null;
  const measured = poseOf(json["measured"]);
  const graph = poseOf(json["graph"]);
  if (measured === null || graph === null) return null;
  const id = numberOf(json["id"]) ?? -1;
  return { id, from: scanOf(json["from"]), to: scanOf(json["to"]), measured, graph };
}
