/** Runs to look at: everything that a server of the contract sends, made by code. */
import { apply, compose, inverse, type Pose } from "../src/geometry.ts";
import type { ClosureState } from "../src/json_messages.ts";
import { encodePng } from "./png.ts";
import { Random } from "./random.ts";
import { TiledMap, type Tiles } from "./tiled_map.ts";
import { cast, drive, office, route, type Segment, type Stop } from "./world.ts";

export interface Node {
  t: number;
  pose: Pose;
  sigma: number;
  submap: number;
  drive: number;
  travelled: number;
}

export interface DemoClosure {
  id: number;
  from: number;
  to: number;
  state: ClosureState;
  reason: string;
  measured: Pose;
}

export interface Run {
  name: string;
  resolution: number;
  size: number;
  nodes: Node[];
  closures: DemoClosure[];
  walls: Segment[];
  /** All tiles, or those seen up to a node. */
  tiles(): Tiles;
  quality: { x: number; y: number; resolution: number; png: string } | null;
  texture: { x: number; y: number; resolution: number; png: string } | null;
}

export const kBeams = 181;
export const kRange = 12;
export const kAngles = Array.from(
  { length: kBeams },
  (_, i) => -Math.PI / 2 + (i * Math.PI) / (kBeams - 1),
);
const kBegin = 1_700_000_000;

export function scanAt(walls: Segment[], pose: Pose): number[] {
  return kAngles.map((angle) => cast(walls, pose, pose.yaw + angle, kRange));
}

export function pointsAt(walls: Segment[], pose: Pose): number[] {
  return scanAt(walls, pose).flatMap((range, i) => {
    const angle = kAngles[i] ?? 0;
    return Number.isFinite(range) ? [range * Math.cos(angle), range * Math.sin(angle)] : [];
  });
}

function nodesOf(stops: Stop[], drive: number, firstSubmap: number, before: number): Node[] {
  return stops.map((stop) => ({
    t: stop.t,
    pose: stop.pose,
    sigma: 0.008 + 0.05 * Math.abs(Math.sin(stop.travelled / 45)) ** 2,
    submap: firstSubmap + Math.floor(stop.travelled / 4),
    drive,
    travelled: before + stop.travelled,
  }));
}

const kReasons: Record<ClosureState, string[]> = {
  standing: [""],
  waiting: ["waits for a second closure that asks for the same"],
  rejected: [
    "ambiguous: another place matches as well",
    "too little overlap",
    "the places around do not bear it out",
  ],
  revoked: ["contradicts the rest of the graph"],
};

function stateFor(random: Random): ClosureState {
  const chance = random.next();
  return chance < 0.8
    ? "standing"
    : chance < 0.85
      ? "waiting"
      : chance < 0.95
        ? "rejected"
        : "revoked";
}

function closure(id: number, from: number, to: number, nodes: Node[], random: Random): DemoClosure {
  const state = stateFor(random);
  const off = state === "standing" ? 0.012 : state === "waiting" ? 0.05 : 0.3;
  const truth = compose(inverse((nodes[from] as Node).pose), (nodes[to] as Node).pose);
  const error = { x: random.normal(off), y: random.normal(off), yaw: random.normal(off / 5) };
  const reasons = kReasons[state];
  const reason = reasons[random.integer(reasons.length)] ?? "";
  return { id, from, to, state, reason, measured: compose(truth, error) };
}

function closuresOf(nodes: Node[], random: Random): DemoClosure[] {
  const closures: DemoClosure[] = [];
  for (let j = 0; j < nodes.length; j += 6) {
    for (let i = 0; i + 120 < j; i += 17) {
      const a = (nodes[i] as Node).pose;
      const b = (nodes[j] as Node).pose;
      const apart = Math.hypot(a.x - b.x, a.y - b.y);
      const facing = Math.cos(a.yaw - b.yaw);
      if (apart < 2.4 && facing > 0.3 && random.next() < 0.55)
        closures.push(closure(closures.length, i, j, nodes, random));
    }
  }
  return closures;
}

function picture(
  box: { x: number; y: number; w: number; h: number },
  resolution: number,
  colour: (x: number, y: number) => [number, number, number, number],
) {
  const width = Math.round(box.w / resolution);
  const height = Math.round(box.h / resolution);
  const data = new Uint8Array(4 * width * height);
  for (let row = 0; row < height; row++) {
    for (let column = 0; column < width; column++) {
      const x = box.x + (column + 0.5) * resolution;
      const y = box.y + (height - row - 0.5) * resolution;
      data.set(colour(x, y), 4 * (row * width + column));
    }
  }
  const png = encodePng({ width, height, data }).toString("base64");
  return { x: box.x, y: box.y, resolution, png };
}

/** An office of 1,000 square metres in two drives, as a finished folder would tell it. */
export function officeRun(): Run {
  const random = new Random(1);
  const walls = office();
  const first = drive(route(), 0.4, 0.8, kBegin);
  const last = first[first.length - 1] as Stop;
  const again = drive(route().slice(0, 240), 0.4, 0.8, last.t + 5);
  const nodes = nodesOf(first, 0, 0, 0);
  const submaps = (nodes[nodes.length - 1] as Node).submap + 1;
  nodes.push(...nodesOf(again, 1, submaps, last.travelled));
  const map = new TiledMap(0.05, 128);
  for (const { pose } of nodes) {
    map.addScan(pose, kAngles, scanAt(walls, pose), kRange);
  }
  const box = { x: 0, y: 0, w: 42, h: 24 };
  return {
    name: "demo office",
    resolution: map.resolution,
    size: map.size,
    nodes,
    closures: closuresOf(nodes, random),
    walls,
    tiles: () => map.take(true),
    quality: picture(box, 0.25, (x, y) => {
      const share = Math.abs(Math.sin(x / 9) * Math.cos(y / 7));
      return [Math.round(255 * share), Math.round(200 * (1 - share)), 60, 170];
    }),
    texture: picture(box, 0.1, (x, y) => {
      const checked = (Math.floor(x / 0.6) + Math.floor(y / 0.6)) % 2 === 0;
      const seen = Math.abs(y - 12) < 1.2 ? 255 : 0;
      return checked ? [176, 150, 118, seen] : [150, 124, 96, seen];
    }),
  };
}

function patternTile(column: number, row: number, size: number): Uint8Array {
  const cells = new Uint8Array(size * size);
  const room = 140;
  for (let y = 0; y < size; y++) {
    for (let x = 0; x < size; x++) {
      const [u, v] = [(column * size + x) % room, (row * size + y) % room];
      const wall = (u < 3 && Math.abs(v - 70) > 14) || (v < 3 && Math.abs(u - 70) > 14);
      const dark = u > 4 && u < 12 && v > 4 && v < 12;
      cells[y * size + x] = wall ? 100 : dark ? 255 : (x * 7 + y * 13) % 9;
    }
  }
  return cells;
}

/** 100,000 square metres at 5 cm, 20,000 nodes and 5,000 closures: what must still draw well. */
export function largeRun(tilesASide = 25, nodeCount = 20_000, closureCount = 5_000): Run {
  const random = new Random(2);
  const [size, resolution] = [256, 0.05];
  const side = tilesASide * size * resolution;
  const lanes = 40;
  const nodes: Node[] = Array.from({ length: nodeCount }, (_, i) => {
    const at = (i / nodeCount) * lanes;
    const lane = Math.floor(at);
    const share = lane % 2 === 0 ? at - lane : 1 - (at - lane);
    const pose = {
      x: 4 + share * (side - 8),
      y: 3 + (lane / lanes) * (side - 6),
      yaw: (lane % 2) * Math.PI,
    };
    const drive = Math.floor((3 * i) / nodeCount);
    return {
      t: kBegin + i,
      pose,
      sigma: 0.01 + (0.2 * i) / nodeCount,
      submap: i >> 3,
      drive,
      travelled: 0.6 * i,
    };
  });
  // From lane to lane, where both pass the same place.
  const perLane = nodeCount / lanes;
  const closures = Array.from({ length: closureCount }, (_, id) => {
    const lane = random.integer(lanes - 1);
    const along = random.integer(perLane);
    const from = Math.floor(lane * perLane + along);
    const to = Math.floor((lane + 2) * perLane - 1 - along + random.between(-5, 5));
    return closure(id, from, Math.min(nodeCount - 1, Math.max(from + 1, to)), nodes, random);
  });
  const ids: number[] = [];
  const cells: Uint8Array[] = [];
  for (let row = 0; row < tilesASide; row++) {
    for (let column = 0; column < tilesASide; column++) {
      ids.push(column, row);
      cells.push(patternTile(column, row, size));
    }
  }
  const walls = office();
  return {
    name: "large",
    resolution,
    size,
    nodes,
    closures,
    walls,
    tiles: () => ({ ids, cells }),
    quality: null,
    texture: null,
  };
}

/** A turned square about each submap's first node. */
export function submapsOf(nodes: Node[]) {
  const first = new Map<number, Node>();
  for (const node of nodes) if (!first.has(node.submap)) first.set(node.submap, node);
  const last = Math.max(...first.keys());
  return [...first].map(([id, { pose }]) => ({
    id,
    state: id === last ? "open" : id % 23 === 7 ? "dropped" : "frozen",
    pose: [pose.x, pose.y, pose.yaw],
    outline: [
      [-3, -3],
      [5, -3],
      [5, 3],
      [-3, 3],
    ].flatMap(([x = 0, y = 0]) => {
      const p = apply(pose, { x, y });
      return [p.x, p.y];
    }),
  }));
}
