/** The messages of a run as the wire has them. */
import type { Pose } from "../src/geometry.ts";
import { CdrWriter } from "./cdr_writer.ts";
import { type DemoClosure, kAngles, kRange, type Node, type Run, submapsOf } from "./run.ts";
import type { Tiles } from "./tiled_map.ts";

export function transforms(t: number, list: [string, string, Pose][]): Uint8Array {
  const writer = new CdrWriter().u32(list.length);
  for (const [parent, child, { x, y, yaw }] of list) {
    writer.header(t, parent).string(child).pose(x, y, yaw);
  }
  return writer.done();
}

export function laserScan(t: number, ranges: number[]): Uint8Array {
  const [first = 0, second = 0] = kAngles;
  const last = kAngles[kAngles.length - 1] ?? 0;
  return new CdrWriter()
    .header(t, "laser")
    .f32(first, last, second - first, 0, 0, 0.05, kRange)
    .f32s(ranges)
    .f32s([])
    .done();
}

export function poseWithCovariance(t: number, { x, y, yaw }: Pose, sigma: number): Uint8Array {
  const covariance = new Array<number>(36).fill(0);
  covariance[0] = (sigma * 3) ** 2;
  covariance[1] = covariance[6] = 0.5 * sigma ** 2;
  covariance[7] = sigma ** 2;
  covariance[35] = (sigma / 3) ** 2;
  return new CdrWriter()
    .header(t, "map")
    .pose(x, y, yaw)
    .f64(...covariance)
    .done();
}

export function mapTiles(
  run: Pick<Run, "resolution" | "size">,
  tiles: Tiles,
  whole: boolean,
): Uint8Array {
  const cells = new Uint8Array(tiles.cells.length * run.size ** 2);
  tiles.cells.forEach((tile, i) => cells.set(tile, i * run.size ** 2));
  return new CdrWriter()
    .f64(run.resolution)
    .u32(run.size)
    .u8(whole ? 1 : 0)
    .i32s(tiles.ids)
    .u8s(cells)
    .done();
}

export function trajectory(nodes: Node[], first: number, count: number): Uint8Array {
  const given = nodes.slice(first, count);
  return new CdrWriter()
    .u32(first)
    .u32(count)
    .f64s(given.map((node) => node.t))
    .f32s(given.flatMap(({ pose }) => [pose.x, pose.y, pose.yaw]))
    .f32s(given.map((node) => node.sigma))
    .u32s(given.map((node) => node.submap))
    .u32s(given.map((node) => node.drive))
    .done();
}

export function particles(t: number, poses: Pose[]): Uint8Array {
  const writer = new CdrWriter().header(t, "map").u32(poses.length);
  for (const { x, y, yaw } of poses) writer.pose(x, y, yaw);
  return writer.done();
}

function closureJson(nodes: Node[], { id, from, to, state, reason }: DemoClosure) {
  const a = nodes[from] as Node;
  const b = nodes[to] as Node;
  const good = state === "standing";
  return {
    id,
    from,
    to,
    from_t: a.t,
    to_t: b.t,
    from_submap: a.submap,
    to_submap: b.submap,
    state,
    reason,
    score: good ? 0.7 + ((id * 37) % 25) / 100 : 0.4 + ((id * 37) % 25) / 100,
    second_score: id % 5 === 0 ? null : 0.3 + ((id * 53) % 30) / 100,
    overlap: 0.4 + ((id * 29) % 50) / 100,
    agreement: good ? 0.95 : 0.7,
    chi2: good ? ((id * 17) % 60) / 10 : 18 + ((id * 17) % 300) / 10,
    sigma_m: 0.004 + ((id * 13) % 40) / 1000,
    by_appearance: id % 7 === 3,
  };
}

export function closures(nodes: Node[], list: DemoClosure[]): object {
  const entries = list.map((one, id) => ({ ...closureJson(nodes, one), id }));
  return { count: entries.length, closures: entries };
}

export function submaps(nodes: Node[]): object {
  const entries = nodes.length > 0 ? submapsOf(nodes) : [];
  return { count: entries.length, submaps: entries };
}

export function status(
  run: Run,
  node: Node,
  count: number,
  known: number,
  localizing: boolean,
): object {
  const closures = run.closures.filter((one) => one.to < known);
  const standing = closures.filter((one) => one.state === "standing").length;
  const states = localizing
    ? ["TRACKING", "DOUBTFUL", "LOST"]
    : ["tracked", "degenerate", "bridged"];
  const state = states[count % 97 < 80 ? 0 : count % 97 < 94 ? 1 : 2];
  return {
    t: node.t,
    status: state,
    scans: count * 4,
    travelled_m: node.travelled,
    submaps: node.submap + 1,
    closures: standing,
    rejected: closures.length - standing,
    map_m2: Math.min(804.9, 40 + count * 1.1),
    realtime: 180 + 60 * Math.sin(count / 40),
    memory_mb: 62 + count / 60,
    figures: {
      sigma_m: node.sigma,
      front_end_ms: 2.1 + 0.6 * Math.sin(count / 7) + (count % 50 === 0 ? 4 : 0),
      probability: 1 - 4 * node.sigma,
      overlap: 0.7 + 0.2 * Math.cos(count / 30),
    },
  };
}

export const kVerdict = {
  verdict: "doubtful",
  sentence: "Wherever places were seen in two visits, the visits agree; two parts hang on little.",
  reasons: [
    "The room in the north-east hangs on one recognised place, and could move by 0.3 m.",
    "12 m of corridor have no features along them; their length is odometry's.",
  ],
  complete: true,
  places: [
    { x: 38.5, y: 18.5, text: "hangs on one recognised place" },
    { x: 21, y: 12, text: "bare corridor, may be 0.2 m too long" },
  ],
};

export function warnings(begin: number): object {
  return {
    warnings: [
      { t: null, text: "No gyro: turns come from odometry alone." },
      { t: begin + 61.4, text: "Scans were missing for 1.2 s; odometry bridged them." },
      { t: begin + 203, text: "A wheel slipped by about 0.14 m." },
    ],
  };
}
