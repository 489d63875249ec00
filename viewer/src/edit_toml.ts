/** Edits as the server reads them: TOML, in the words of docs/editing.md. The only place that writes it. */
import type { EditState } from "./edits.ts";
import type { Point, Pose } from "./geometry.ts";

export const kPolygonKinds = ["crop", "erase", "keep_out", "speed"] as const;
export type PolygonKind = (typeof kPolygonKinds)[number];

export type SpeedLimit = { percent: number } | { metresPerSecond: number };

/** A micrometre and a microradian: finer than any map. */
const kDecimals = 6;

export function tomlNumber(value: number): string {
  if (!Number.isFinite(value)) throw new RangeError(`${value} is no number of an edit`);
  const text = value.toFixed(kDecimals).replace(/\.?0+$/, "");
  return text === "-0" ? "0" : text;
}

export function tomlIndex(value: number): string {
  if (!Number.isSafeInteger(value) || value < 0) throw new RangeError(`${value} is no node`);
  return String(value);
}

/** In quotes; what TOML does not take as it is becomes an escape, half a character a mark. */
export function tomlText(text: string): string {
  const whole = text.replace(
    /[\ud800-\udbff](?![\udc00-\udfff])|(?<![\ud800-\udbff])[\udc00-\udfff]/g,
    "\ufffd",
  );
  const escaped = whole.replace(/["\\]/g, "\\$&").replace(/[\u0000-\u001f\u007f]/g, (letter) => {
    return `\\u${letter.charCodeAt(0).toString(16).toUpperCase().padStart(4, "0")}`;
  });
  return `"${escaped}"`;
}

function edit(kind: string, lines: string[] = []): string {
  return [`[[edit]]`, `kind = ${tomlText(kind)}`, ...lines, ""].join("\n");
}

function placesOf(from: number, to: number): string[] {
  return [`from_node = ${tomlIndex(from)}`, `to_node = ${tomlIndex(to)}`];
}

function poseOf({ x, y, yaw }: Pose): string[] {
  return [`x_m = ${tomlNumber(x)}`, `y_m = ${tomlNumber(y)}`, `yaw_rad = ${tomlNumber(yaw)}`];
}

export function deleteClosure(from: number, to: number): string {
  return edit("delete_closure", placesOf(from, to));
}

export interface AddedClosure {
  from: number;
  to: number;
  /** Where `to` is, seen from `from`; null without a guess. */
  guess: Pose | null;
  halfWindow: number | null;
  force: boolean;
}

export function addClosure({ from, to, guess, halfWindow, force }: AddedClosure): string {
  const lines = placesOf(from, to);
  if (guess !== null) lines.push(...poseOf(guess));
  if (halfWindow !== null) lines.push(`half_window_m = ${tomlNumber(halfWindow)}`);
  if (force) lines.push("force = true");
  return edit("add_closure", lines);
}

/** A stretch of the path, whichever end is told first. */
export function ignoreStretch(one: number, other: number): string {
  return edit("ignore", placesOf(Math.min(one, other), Math.max(one, other)));
}

export function polygonEdit(
  kind: PolygonKind,
  corners: readonly Point[],
  name = "",
  limit: SpeedLimit | null = null,
): string {
  const lines: string[] = [];
  if (name !== "") lines.push(`name = ${tomlText(name)}`);
  const list = corners.map(({ x, y }) => `[${tomlNumber(x)}, ${tomlNumber(y)}]`);
  lines.push(`polygon = [${list.join(", ")}]`);
  if (limit !== null) {
    lines.push(
      "percent" in limit
        ? `percent = ${tomlNumber(limit.percent)}`
        : `limit_m_s = ${tomlNumber(limit.metresPerSecond)}`,
    );
  }
  return edit(kind, lines);
}

export function straighten(): string {
  return edit("straighten");
}

/** With a heading, that direction becomes the one of x. */
export function origin({ x, y }: Point, yaw: number | null): string {
  const lines = [`x_m = ${tomlNumber(x)}`, `y_m = ${tomlNumber(y)}`];
  if (yaw !== null) lines.push(`yaw_rad = ${tomlNumber(yaw)}`);
  return edit("origin", lines);
}

/**
 * Points and guesses on the page are in the frame of the map as it is shown: behind other edits the
 * server is told so. It merges markers that follow on each other.
 */
export function onShownMap(toml: string, state: Pick<EditState, "edits"> | null): string {
  return (state?.edits.length ?? 0) > 0 ? `${edit("as_edited")}\n${toml}` : toml;
}

const kEscapes: Record<string, string> = { b: "\b", t: "\t", n: "\n", f: "\f", r: "\r" };

function plainOf(escaped: string): string {
  return escaped.replace(
    /\\(u[0-9a-fA-F]{4}|U[0-9a-fA-F]{8}|.)/g,
    (whole: string, code: string) => {
      if (code.length === 1) return kEscapes[code] ?? code;
      const point = Number.parseInt(code.slice(1), 16);
      return point <= 0x10ffff ? String.fromCodePoint(point) : whole;
    },
  );
}

/** The text or number of a key in an edit's own words; null where there is none. */
export function valueIn(toml: string, key: string): string | null {
  const found = new RegExp(
    `^\\s*${key}\\s*=\\s*(?:"((?:[^"\\\\]|\\\\.)*)"|'([^']*)'|([-+\\w.]+))`,
    "m",
  ).exec(toml);
  if (found === null) return null;
  const [, quoted, literal, bare] = found;
  return quoted !== undefined ? plainOf(quoted) : (literal ?? bare ?? null);
}
