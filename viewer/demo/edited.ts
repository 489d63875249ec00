/** What an edit does to the made run, plausibly. */
import { areaOf } from "../src/edit/polygon.ts";
import { kPolygonKinds } from "../src/edit_toml.ts";
import { apply, compose, inverse, kIdentity, type Point, type Pose } from "../src/geometry.ts";
import type { DemoClosure, Node, Run } from "./run.ts";
import type { Tiles } from "./tiled_map.ts";
import { kVerdict } from "./messages.ts";

export type Table = Record<string, unknown> & { kind: string; toml: string };

export class BadRequest extends Error {
  constructor(
    readonly status: number,
    message: string,
  ) {
    super(message);
  }
}

/** As much TOML as edits need: a value is the JSON of its kind. */
export function parseEdits(text: string): Table[] {
  const tables: Table[] = [];
  text.split("\n").forEach((line, i) => {
    const fault = (what: string) => new BadRequest(400, `line ${i + 1}: ${what}`);
    const plain = line.trim();
    if (plain === "" || plain.startsWith("#")) return;
    if (plain === "[[edit]]") {
      tables.push({ kind: "", toml: "[[edit]]\n" });
      return;
    }
    const table = tables[tables.length - 1];
    const found = /^(\w+) = (.+)$/.exec(plain);
    if (table === undefined || found === null) throw fault("neither [[edit]] nor a key");
    const [, key = "", value = ""] = found;
    try {
      table[key] = JSON.parse(value);
    } catch {
      throw fault(`${key} has no value`);
    }
    table.toml += `${plain}\n`;
  });
  for (const { kind } of tables) {
    const known = ["delete_closure", "add_closure", "ignore", "straighten", "origin", "as_edited"];
    if (![...known, ...kPolygonKinds].includes(kind))
      throw new BadRequest(400, `kind ${JSON.stringify(kind)} is unknown`);
  }
  if (tables.length === 0) throw new BadRequest(400, "there is no edit in it");
  return tables;
}

export interface Outline {
  kind: string;
  /** In the frame of the map without edits. */
  corners: Point[];
}

/** The map while one edit after the other is done to it. */
export class Edited {
  nodes: Pose[];
  closures: DemoClosure[];
  /** now_T_before */
  frame: Pose = kIdentity;
  told: Pose = kIdentity;
  readonly outlines: (Outline | null)[] = [];
  balance = 0;
  straightened = false;
  speedIn = "";

  constructor(readonly run: Run) {
    this.nodes = run.nodes.map(({ pose }) => pose);
    this.closures = [...run.closures];
  }

  get poses(): Pose[] {
    return this.nodes.map((pose) => compose(this.frame, pose));
  }

  get verdict(): string {
    return this.balance > 0 ? "good" : this.balance < 0 ? "bad" : "doubtful";
  }

  /** Bends the path behind `from`, as a closure that goes or comes does. */
  bend(from: number, to: number, dx: number, dy: number): void {
    this.nodes = this.nodes.map((pose, i) => {
      const share = Math.min(1, Math.max(0, (i - from) / Math.max(1, to - from)));
      return { x: pose.x + dx * share, y: pose.y + dy * share, yaw: pose.yaw };
    });
  }

  onBase(p: Point): Point {
    return apply(inverse(this.told), p);
  }
}

export class Refusal extends Error {
  constructor(
    message: string,
    readonly closure: object | null = null,
  ) {
    super(message);
  }
}

export interface Done {
  told: string;
  closure?: object;
}

const kNear = 30;

function nodeOf(table: Table, key: string, run: Run): number {
  const node = table[key];
  if (typeof node !== "number" || !Number.isInteger(node))
    throw new BadRequest(400, `${table.kind} must tell ${key}`);
  if (node < 0 || node >= run.nodes.length) throw new Refusal(`node ${node} is not of the path`);
  return node;
}

function deleteClosure(table: Table, map: Edited): Done {
  const [from, to] = [nodeOf(table, "from_node", map.run), nodeOf(table, "to_node", map.run)];
  const found = map.closures.find(
    (one) => one.from === from && one.to === to && one.state === "standing",
  );
  if (found === undefined) throw new Refusal("no closure stands between these places");
  map.closures = map.closures.filter((one) => one !== found);
  const moved = 0.06 + 0.04 * (found.id % 5);
  map.bend(from, to, 0, moved);
  map.balance--;
  return { told: `closure ${found.id} is out; the map moved by up to ${moved.toFixed(2)} m` };
}

function addClosure(table: Table, map: Edited): Done {
  const [from, to] = [nodeOf(table, "from_node", map.run), nodeOf(table, "to_node", map.run)];
  if (Math.abs(to - from) < kNear)
    throw new Refusal("both places are neighbours on the path, which ties them already");
  const { nodes } = map.run;
  const truth = compose(inverse((nodes[from] as Node).pose), (nodes[to] as Node).pose);
  const { x_m: x, y_m: y, yaw_rad: yaw, force } = table;
  const guess =
    typeof x === "number" && typeof y === "number" && typeof yaw === "number"
      ? { x, y, yaw }
      : truth;
  const off = Math.hypot(guess.x - truth.x, guess.y - truth.y);
  const fits = off < 1 && Math.abs(Math.sin((guess.yaw - truth.yaw) / 2)) < 0.1;
  const score = fits ? 0.82 : Math.max(0.21, 0.46 - off / 20);
  const figures = {
    score,
    overlap: fits ? 0.71 : 0.34,
    agreement: fits ? 0.96 : 0.58,
    second_score: guess === truth ? 0.41 : null,
    chi2: fits ? 1.7 : 88.5,
  };
  if (!fits && force !== true) {
    const words = `no pose within 1.00 m of the guess scores 0.55; the best has ${score.toFixed(2)}`;
    throw new Refusal(words, figures);
  }
  const id =
    1 + Math.max(...map.run.closures.map((one) => one.id), ...map.closures.map((c) => c.id));
  const measured = fits ? truth : guess;
  map.closures.push({ id, from, to, state: "standing", reason: "", measured });
  const [dx, dy] = fits ? [0.02, -0.03] : [guess.x - truth.x, guess.y - truth.y];
  map.bend(from, to, dx, dy);
  map.balance += fits ? 1 : -2;
  const how = fits ? "" : ", by force: no scan bears it out";
  return { told: `closure ${id} joins both places${how}`, closure: figures };
}

function polygonOf(table: Table, map: Edited): Point[] {
  const rows = table["polygon"];
  const sound =
    Array.isArray(rows) &&
    rows.length >= 3 &&
    rows.every((row) => Array.isArray(row) && row.length === 2 && row.every(Number.isFinite));
  if (!sound)
    throw new BadRequest(400, `${table.kind} must have a polygon of three corners at least`);
  return (rows as [number, number][]).map(([x, y]) => map.onBase({ x, y }));
}

function drawPolygon(table: Table, map: Edited): Done {
  const corners = polygonOf(table, map);
  const area = `${Math.abs(areaOf(corners)).toFixed(1)} m2`;
  if (table.kind === "speed") {
    const unit = "percent" in table ? "percent" : "limit_m_s";
    if (map.speedIn !== "" && map.speedIn !== unit)
      throw new Refusal("speeds of one map are all told in percent, or all in m/s");
    map.speedIn = unit;
  }
  map.outlines[map.outlines.length - 1] = { kind: table.kind, corners };
  const told: Record<string, string> = {
    crop: `what lies outside of ${area} becomes unknown`,
    erase: `what stands on ${area} becomes free`,
    keep_out: `${area} are not to be entered`,
    speed: `${area} with at most ${String(table["percent"] ?? table["limit_m_s"])} ${
      map.speedIn === "percent" ? "percent" : "m/s"
    }`,
  };
  return { told: told[table.kind] ?? "" };
}

function setOrigin(table: Table, map: Edited): Done {
  const { x_m: x, y_m: y, yaw_rad: yaw } = table;
  if (typeof x !== "number" || typeof y !== "number")
    throw new BadRequest(400, "origin must tell x_m and y_m");
  if (typeof yaw === "number" && map.straightened)
    throw new Refusal("the map is straightened, and an origin with a yaw_rad turns it, too");
  const now = apply(compose(map.frame, inverse(map.told)), { x, y });
  const turn = typeof yaw === "number" ? yaw : 0;
  map.frame = compose(inverse({ ...now, yaw: turn }), map.frame);
  return { told: `(${x.toFixed(2)}, ${y.toFixed(2)}) becomes (0, 0)` };
}

export function perform(table: Table, map: Edited): Done {
  switch (table.kind) {
    case "delete_closure":
      return deleteClosure(table, map);
    case "add_closure":
      return addClosure(table, map);
    case "ignore": {
      const [from, to] = [nodeOf(table, "from_node", map.run), nodeOf(table, "to_node", map.run)];
      return { told: `${4 * (Math.abs(to - from) + 1)} scans are not used` };
    }
    case "straighten":
      if (map.straightened) throw new Refusal("its walls run along x and y already");
      map.straightened = true;
      map.frame = compose({ x: 0, y: 0, yaw: 0.026 }, map.frame);
      return { told: "the map turned by 1.49 deg; 81 % of its walls run along x and y" };
    case "origin":
      return setOrigin(table, map);
    case "as_edited":
      map.told = map.frame;
      return { told: "what follows is told on the map with the edits so far" };
    default:
      return drawPolygon(table, map);
  }
}

export function shiftOf(before: Pose[], after: Pose[]): object {
  let [sum, largest, turned] = [0, 0, 0];
  before.forEach((a, i) => {
    const b = after[i] ?? a;
    const apart = Math.hypot(b.x - a.x, b.y - a.y);
    sum += apart;
    largest = Math.max(largest, apart);
    turned = Math.max(turned, Math.abs(Math.sin(b.yaw - a.yaw)));
  });
  return { mean_m: sum / Math.max(1, before.length), largest_m: largest, largest_rad: turned };
}

export const kSentences: Record<string, string> = {
  good: "Wherever places were seen in two visits, the visits agree.",
  doubtful: kVerdict.sentence,
  bad: "Visits of the same place contradict each other by more than 0.1 m.",
};

function within(p: Point, corners: Point[]): boolean {
  let inside = false;
  corners.forEach((a, i) => {
    const b = corners[(i + 1) % corners.length] as Point;
    const crosses = a.y > p.y !== b.y > p.y;
    if (crosses && p.x < a.x + ((p.y - a.y) / (b.y - a.y)) * (b.x - a.x)) inside = !inside;
  });
  return inside;
}

/** The run's cells in another frame, cropped and erased. */
export function redrawn(run: Run, frame: Pose, outlines: Outline[]): Tiles {
  const { resolution, size } = run;
  const base = run.tiles();
  if (frame === kIdentity && outlines.length === 0) return base;
  const side = size * resolution;
  const known = new Map<string, Uint8Array>();
  const wanted = new Set<string>();
  base.cells.forEach((cells, i) => {
    const [column = 0, row = 0] = base.ids.slice(2 * i, 2 * i + 2);
    known.set(`${column},${row}`, cells);
    for (const dx of [0, 0.5, 1]) {
      for (const dy of [0, 0.5, 1]) {
        const p = apply(frame, { x: (column + dx) * side, y: (row + dy) * side });
        wanted.add(`${Math.floor(p.x / side)},${Math.floor(p.y / side)}`);
      }
    }
  });
  const back = inverse(frame);
  const crops = outlines.filter((one) => one.kind === "crop");
  const erased = outlines.filter((one) => one.kind === "erase");
  const cellAt = (p: Point): number => {
    const [u, v] = [Math.floor(p.x / resolution), Math.floor(p.y / resolution)];
    const cells = known.get(`${Math.floor(u / size)},${Math.floor(v / size)}`);
    const inTile = (value: number) => ((value % size) + size) % size;
    const value = cells?.[inTile(v) * size + inTile(u)] ?? 255;
    if (value === 255 || (crops.length > 0 && !crops.some((one) => within(p, one.corners))))
      return 255;
    return erased.some((one) => within(p, one.corners)) ? 0 : value;
  };
  const tiles: Tiles = { ids: [], cells: [] };
  for (const key of wanted) {
    const [column = 0, row = 0] = key.split(",").map(Number);
    const cells = new Uint8Array(size * size);
    for (let v = 0; v < size; v++) {
      for (let u = 0; u < size; u++) {
        const x = column * side + (u + 0.5) * resolution;
        const y = row * side + (v + 0.5) * resolution;
        cells[v * size + u] = cellAt(apply(back, { x, y }));
      }
    }
    tiles.ids.push(column, row);
    tiles.cells.push(cells);
  }
  return tiles;
}
