/** All that the page knows of the run. Messages fill it, views are told which part has changed. */
import type { EditState } from "./edits.ts";
import { compose, type Ellipse, ellipseOf, emptyBox, kIdentity, type Pose } from "./geometry.ts";
import type { About, Closure, Picture, Status, Submap, Verdict, Warning } from "./json_messages.ts";
import type { LaserScan, MapTiles, OccupancyGrid, Transform } from "./messages.ts";
import type { PlaybackStatus } from "./protocol.ts";
import { Series } from "./series.ts";
import { Track } from "./track.ts";

export type Part =
  | "about"
  | "connection"
  | "playback"
  | "time"
  | "pose"
  | "scan"
  | "map"
  | "trajectory"
  | "particles"
  | "status"
  | "closures"
  | "submaps"
  | "verdict"
  | "warnings"
  | "quality"
  | "texture"
  | "edits"
  | "reset";

export type Connection =
  | { state: "connecting" }
  | { state: "open" }
  | { state: "lost"; retryAt: number }
  | { state: "refused"; retryAt: number; reason: string };

export interface RobotState {
  pose: Pose;
  ellipse: Ellipse | null;
  yawSigma: number;
}

export interface PlacedScan {
  scan: LaserScan;
  /** Between it and the pose that it was placed by [s]. */
  apart: number;
  /** x and y in turn, in the map's frame; only the first `length` numbers count. */
  points: Float32Array;
  length: number;
}

interface PlaceOfSensor {
  pose: Pose;
  upsideDown: boolean;
  apart: number;
}

/** Whoever draws the map takes tiles as they come; the model keeps only where they are. */
export interface MapSink {
  addTiles(tiles: MapTiles): void;
  /** Whether there were more tiles than can be drawn. */
  readonly full: boolean;
  setGrid(grid: OccupancyGrid): void;
  clear(): void;
}

const kMostSeries = 64;
const kKeptTransforms = 64;
const kMostNotes = 50;
const kMostScans = 8;

export class Model {
  connection: Connection = { state: "connecting" };
  about: About | null = null;
  serverName = "";
  canSeek = false;
  start: number | null = null;
  end: number | null = null;
  time: number | null = null;
  playback: PlaybackStatus = "playing";
  speed = 1;
  robot: RobotState | null = null;
  /** The last scan of each laser, by topic. */
  readonly scans = new Map<string, PlacedScan>();
  readonly track = new Track();
  /** Counts replacements of the path, so that a drawn one knows whether it is old. */
  trackVersion = 0;
  particles: Float32Array = new Float32Array(0);
  status: Status | null = null;
  readonly series = new Map<string, Series>();
  closures: Closure[] = [];
  submaps: Submap[] = [];
  verdict: Verdict | null = null;
  warnings: Warning[] = [];
  /** What the server said of itself, and messages that could not be read. */
  notes: string[] = [];
  quality: Picture | null = null;
  texture: Picture | null = null;
  /** Null until the server has told, and where it lets nobody edit. */
  edits: EditState | null = null;
  readonly mapBox = emptyBox();
  damaged = 0;
  received = 0;
  mapSink: MapSink | null = null;

  private readonly listeners = new Map<Part, (() => void)[]>();
  private readonly transforms: Transform[] = [];
  private readonly fixed = new Map<string, Transform>();

  on(parts: Part[], listener: () => void): void {
    for (const part of parts) {
      const all = this.listeners.get(part) ?? [];
      all.push(listener);
      this.listeners.set(part, all);
    }
  }

  changed(part: Part): void {
    for (const listener of this.listeners.get(part) ?? []) listener();
  }

  /** Another run: nothing that was known holds any more. */
  reset(): void {
    this.about = null;
    this.start = this.end = this.time = null;
    this.playback = "playing";
    this.canSeek = false;
    this.robot = null;
    this.scans.clear();
    this.track.clear();
    this.trackVersion++;
    this.particles = new Float32Array(0);
    this.status = null;
    this.series.clear();
    this.closures = [];
    this.submaps = [];
    this.verdict = null;
    this.warnings = [];
    this.notes = [];
    this.quality = this.texture = null;
    this.edits = null;
    Object.assign(this.mapBox, emptyBox());
    this.transforms.length = 0;
    this.fixed.clear();
    this.mapSink?.clear();
    this.changed("reset");
  }

  setTime(time: number): void {
    this.time = time;
    this.changed("time");
  }

  note(text: string): void {
    if (this.notes.includes(text)) return;
    this.notes.push(text);
    if (this.notes.length > kMostNotes) this.notes.shift();
    this.changed("warnings");
  }

  addTransforms(given: Transform[], fixed: boolean): void {
    for (const one of given) {
      if (fixed) this.fixed.set(one.child, one);
      else this.transforms.push(one);
    }
    const surplus = this.transforms.length - kKeptTransforms;
    if (surplus > 0) this.transforms.splice(0, surplus);
    // A scan may come before the pose that it was taken at.
    for (const [topic, { scan, apart }] of this.scans) {
      if (!fixed && apart === 0) continue;
      const now = this.placeOf(scan.header.frame, scan.header.stamp);
      if (fixed || now.apart < apart) this.setScan(topic, scan);
    }
  }

  setRobot(pose: Pose, covariance: [number, number, number], yawVariance: number): void {
    if (!Number.isFinite(pose.x + pose.y + pose.yaw)) return;
    const [xx, xy, yy] = covariance;
    const ellipse = Number.isFinite(xx + xy + yy) && xx + yy > 0 ? ellipseOf(xx, xy, yy) : null;
    this.robot = { pose, ellipse, yawSigma: Math.sqrt(Math.max(0, yawVariance)) };
    this.changed("pose");
  }

  /** Where the frame of a sensor lay on the map at a time. */
  private placeOf(frame: string, stamp: number): PlaceOfSensor {
    const mount = this.fixed.get(frame);
    let robot: Pose | null = null;
    let nearest = Infinity;
    for (const one of this.transforms) {
      const apart = Math.abs(one.stamp - stamp);
      if (one.child === (mount?.parent ?? "base_link") && apart <= nearest) {
        nearest = apart;
        robot = one.pose;
      }
    }
    const pose = compose(robot ?? this.robot?.pose ?? kIdentity, mount?.pose ?? kIdentity);
    return { pose, upsideDown: mount?.upsideDown ?? false, apart: nearest };
  }

  setScan(topic: string, scan: LaserScan): void {
    const known = this.scans.get(topic);
    if (known === undefined && this.scans.size >= kMostScans) return;
    const { pose: lidar, upsideDown, apart } = this.placeOf(scan.header.frame, scan.header.stamp);
    const count = scan.ranges.length;
    let points = known?.points ?? new Float32Array(2 * count);
    if (points.length < 2 * count) points = new Float32Array(4 * count);
    const most = scan.rangeMax > 0 ? scan.rangeMax : Infinity;
    let length = 0;
    for (let i = 0; i < count; i++) {
      const range = scan.ranges[i] ?? NaN;
      if (!(range >= scan.rangeMin && range <= most) || !Number.isFinite(range)) continue;
      const beam = scan.angleMin + i * scan.angleIncrement;
      const angle = lidar.yaw + (upsideDown ? -beam : beam);
      points[length++] = lidar.x + range * Math.cos(angle);
      points[length++] = lidar.y + range * Math.sin(angle);
    }
    this.scans.set(topic, { scan, apart, points, length });
    this.changed("scan");
  }

  get scanPoints(): number {
    let count = 0;
    for (const { length } of this.scans.values()) count += length / 2;
    return count;
  }

  setStatus(status: Status): void {
    this.status = status;
    const t = status.t ?? this.time;
    if (t !== null) {
      for (const [name, value] of status.figures) this.addFigure(name, t, value);
      if (status.realtime !== null) this.addFigure("realtime", t, status.realtime);
      if (status.memory !== null) this.addFigure("memory_mb", t, status.memory);
    }
    this.changed("status");
  }

  private addFigure(name: string, t: number, value: number): void {
    let series = this.series.get(name);
    if (series === undefined) {
      if (this.series.size >= kMostSeries) return;
      series = new Series();
      this.series.set(name, series);
    }
    series.add(t, value);
  }
}
