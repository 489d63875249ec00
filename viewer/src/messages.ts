/** Messages in CDR that the page reads: those of ROS 2, and two of our own. */
import { CdrReader, DamagedMessage } from "./cdr.ts";
import { type Pose, yawOf } from "./geometry.ts";

export interface Header {
  /** [s] */
  stamp: number;
  frame: string;
}

export interface Transform {
  stamp: number;
  parent: string;
  child: string;
  pose: Pose;
  /** The child's z points down, as of a laser that hangs. */
  upsideDown: boolean;
}

export interface LaserScan {
  header: Header;
  angleMin: number;
  angleIncrement: number;
  rangeMin: number;
  rangeMax: number;
  ranges: Float32Array;
}

export interface PoseWithCovariance {
  header: Header;
  pose: Pose;
  /** xx, xy, yy [m^2]. */
  covariance: [number, number, number];
  yawVariance: number;
}

export interface OccupancyGrid {
  resolution: number;
  width: number;
  height: number;
  origin: Pose;
  cells: Uint8Array;
}

export interface MapTiles {
  /** [m] a cell */
  resolution: number;
  /** Cells a side of a tile. */
  size: number;
  /** Whatever was known before is to be forgotten. */
  whole: boolean;
  /** Column and row of each tile, in turn. */
  ids: Int32Array;
  cells: Uint8Array;
}

export interface Trajectory {
  /** Index of the first node given; those from there on are replaced. */
  first: number;
  /** Nodes in all, after this message. */
  count: number;
  t: Float64Array;
  /** x, y, yaw of each. */
  poses: Float32Array;
  /** [m] */
  sigma: Float32Array;
  submaps: Uint32Array;
  drives: Uint32Array;
}

const kLargestTile = 4096;
const kMostCells = 1 << 28;

function readStamp(reader: CdrReader): number {
  const seconds = reader.i32();
  return seconds + reader.u32() * 1e-9;
}

function readHeader(reader: CdrReader): Header {
  const stamp = readStamp(reader);
  return { stamp, frame: reader.string() };
}

/** In the plane; and whether z points down. */
function readPoseInSpace(reader: CdrReader): { pose: Pose; upsideDown: boolean } {
  const x = reader.f64();
  const y = reader.f64();
  reader.f64();
  const qx = reader.f64();
  const qy = reader.f64();
  const qz = reader.f64();
  const pose = { x, y, yaw: yawOf(qx, qy, qz, reader.f64()) };
  return { pose, upsideDown: qx * qx + qy * qy > 0.5 };
}

function readPose(reader: CdrReader): Pose {
  return readPoseInSpace(reader).pose;
}

export function readTransforms(bytes: Uint8Array): Transform[] {
  const reader = new CdrReader(bytes);
  const count = reader.count(64);
  const transforms: Transform[] = [];
  for (let i = 0; i < count; i++) {
    const header = readHeader(reader);
    const child = reader.string();
    const { pose, upsideDown } = readPoseInSpace(reader);
    transforms.push({ stamp: header.stamp, parent: header.frame, child, pose, upsideDown });
  }
  return transforms;
}

export function readLaserScan(bytes: Uint8Array): LaserScan {
  const reader = new CdrReader(bytes);
  const header = readHeader(reader);
  const angleMin = reader.f32();
  reader.f32(); // angle_max follows from the others
  const angleIncrement = reader.f32();
  reader.f32(); // time_increment
  reader.f32(); // scan_time
  const rangeMin = reader.f32();
  const rangeMax = reader.f32();
  return { header, angleMin, angleIncrement, rangeMin, rangeMax, ranges: reader.f32s() };
}

export function readPoseWithCovariance(bytes: Uint8Array): PoseWithCovariance {
  const reader = new CdrReader(bytes);
  const header = readHeader(reader);
  const pose = readPose(reader);
  const all = Array.from({ length: 36 }, () => reader.f64());
  const at = (i: number) => all[i] ?? 0;
  return { header, pose, covariance: [at(0), (at(1) + at(6)) / 2, at(7)], yawVariance: at(35) };
}

export function readPoseArray(bytes: Uint8Array): Float32Array {
  const reader = new CdrReader(bytes);
  readHeader(reader);
  const count = reader.count(56);
  const poses = new Float32Array(3 * count);
  for (let i = 0; i < count; i++) {
    const pose = readPose(reader);
    poses.set([pose.x, pose.y, pose.yaw], 3 * i);
  }
  return poses;
}

export function readPath(bytes: Uint8Array): Trajectory {
  const reader = new CdrReader(bytes);
  readHeader(reader);
  const count = reader.count(64);
  const t = new Float64Array(count);
  const poses = new Float32Array(3 * count);
  for (let i = 0; i < count; i++) {
    t[i] = readHeader(reader).stamp;
    const pose = readPose(reader);
    poses.set([pose.x, pose.y, pose.yaw], 3 * i);
  }
  const zeros = new Uint32Array(count);
  const sigma = new Float32Array(count);
  return { first: 0, count, t, poses, sigma, submaps: zeros, drives: zeros };
}

export function readOccupancyGrid(bytes: Uint8Array): OccupancyGrid {
  const reader = new CdrReader(bytes);
  readHeader(reader);
  readStamp(reader); // map_load_time
  const resolution = reader.f32();
  const width = reader.u32();
  const height = reader.u32();
  const origin = readPose(reader);
  const cells = reader.u8s();
  if (!(resolution > 0) || width * height !== cells.length || cells.length > kMostCells) {
    throw new DamagedMessage("a grid whose size is not that of its cells");
  }
  return { resolution, width, height, origin, cells };
}

export function readMapTiles(bytes: Uint8Array): MapTiles {
  const reader = new CdrReader(bytes);
  const resolution = reader.f64();
  const size = reader.u32();
  const whole = reader.bool();
  const ids = reader.i32s();
  const cells = reader.u8s();
  if (!(resolution > 0) || !Number.isFinite(resolution)) throw new DamagedMessage("no resolution");
  if (size < 1 || size > kLargestTile) throw new DamagedMessage("tiles of no usual size");
  if (ids.length % 2 !== 0 || (ids.length / 2) * size * size !== cells.length) {
    throw new DamagedMessage("tiles whose number is not that of their cells");
  }
  return { resolution, size, whole, ids, cells };
}

export function readTrajectory(bytes: Uint8Array): Trajectory {
  const reader = new CdrReader(bytes);
  const first = reader.u32();
  const count = reader.u32();
  const t = reader.f64s();
  const poses = reader.f32s();
  const sigma = reader.f32s();
  const submaps = reader.u32s();
  const drives = reader.u32s();
  const n = t.length;
  const fits = poses.length === 3 * n && [sigma, submaps, drives].every((one) => one.length === n);
  if (!fits || first + n !== count) throw new DamagedMessage("nodes whose numbers differ");
  return { first, count, t, poses, sigma, submaps, drives };
}
