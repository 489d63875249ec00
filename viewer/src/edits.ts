/** The list of edits as the server has it. Whatever text comes, a value of the right shape or null. */
import { type Json, numberOf, numbersOf, objectsOf, parseObject, textOf, wordOf } from "./json.ts";

/** How far what moved: metres and radians. */
export interface Shift {
  mean: number;
  largest: number;
  turned: number;
}

export interface ClosureFigures {
  score: number | null;
  overlap: number | null;
  agreement: number | null;
  secondScore: number | null;
  chi2: number | null;
}

export type VerdictWord = "" | "good" | "doubtful" | "bad";

export interface Edit {
  kind: string;
  /** Its own words in the file. */
  toml: string;
  /** Otherwise it was refused, and changes nothing. */
  applied: boolean;
  told: string;
  seconds: number | null;
  verdictBefore: VerdictWord;
  verdict: VerdictWord;
  shift: Shift | null;
  /** x and y in turn, where it lies on the map now; empty where there is none. */
  polygon: number[];
  closure: ClosureFigures | null;
}

export interface EditState {
  edits: Edit[];
  /** Raised by each change; that of the map in sight, and of the file (-1: none yet). */
  revision: number;
  drawn: number;
  saved: number;
  file: string;
  command: string;
  verdict: VerdictWord;
  sentence: string;
  /** From the map without edits. */
  shift: Shift | null;
}

const kMostEdits = 10_000;

function shiftOf(value: unknown): Shift | null {
  const json = objectsOf([value])[0];
  if (json === undefined) return null;
  const mean = numberOf(json["mean_m"]);
  const largest = numberOf(json["largest_m"]);
  const turned = numberOf(json["largest_rad"]);
  if (mean === null && largest === null && turned === null) return null;
  return { mean: mean ?? 0, largest: largest ?? 0, turned: turned ?? 0 };
}

function figuresOf(value: unknown): ClosureFigures | null {
  const json = objectsOf([value])[0];
  if (json === undefined) return null;
  return {
    score: numberOf(json["score"]),
    overlap: numberOf(json["overlap"]),
    agreement: numberOf(json["agreement"]),
    secondScore: numberOf(json["second_score"]),
    chi2: numberOf(json["chi2"]),
  };
}

function verdictOf(value: unknown): VerdictWord {
  return wordOf(value, ["", "good", "doubtful", "bad"]);
}

function polygonOf(value: unknown): number[] {
  const numbers = numbersOf(value) ?? [];
  return numbers.length >= 6 && numbers.length % 2 === 0 ? numbers : [];
}

function editOf(json: Json): Edit {
  return {
    kind: textOf(json["kind"]),
    toml: textOf(json["toml"]),
    applied: json["applied"] === true,
    told: textOf(json["told"]),
    seconds: numberOf(json["seconds"]),
    verdictBefore: verdictOf(json["verdict_before"]),
    verdict: verdictOf(json["verdict"]),
    shift: shiftOf(json["shift"]),
    polygon: polygonOf(json["polygon"]),
    closure: figuresOf(json["closure"]),
  };
}

/** Null without a list and its revisions: nothing could be said of the map then. */
export function readEditState(text: string): EditState | null {
  const json = parseObject(text);
  if (json === null || !Array.isArray(json["edits"])) return null;
  const edits: unknown[] = json["edits"];
  const revision = numberOf(json["revision"]);
  const drawn = numberOf(json["drawn"]);
  if (revision === null || drawn === null) return null;
  // Of a list with a hole in it nobody knows what is undone next.
  const list = objectsOf(edits);
  if (list.length !== edits.length || list.length > kMostEdits) return null;
  return {
    edits: list.map(editOf),
    revision,
    drawn,
    saved: numberOf(json["saved"]) ?? -1,
    file: textOf(json["file"]),
    command: textOf(json["command"]),
    verdict: verdictOf(json["verdict"]),
    sentence: textOf(json["sentence"]),
    shift: shiftOf(json["shift"]),
  };
}

/** Why a request was refused, in the server's words where it has any. */
export function readRefusal(text: string, status: number): string {
  const words = textOf(parseObject(text)?.["error"]);
  return words || `The server answered with ${status}.`;
}

/** One that a reader did, and not a marker between them. */
export function isMarker(edit: Edit): boolean {
  return edit.kind === "as_edited";
}
