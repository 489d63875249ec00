/** What each topic's messages do to the model. */
import { DamagedMessage } from "./cdr.ts";
import * as json from "./json_messages.ts";
import * as cdr from "./messages.ts";
import type { Model } from "./model.ts";
import type { Channel } from "./protocol.ts";

/** Reads one message; false where what lies before it is missing and all are needed again. */
type Reader = (model: Model, payload: Uint8Array) => boolean | void;

function ofJson<T>(
  read: (text: string) => T | null,
  apply: (model: Model, value: T) => boolean | void,
): Reader {
  return (model, payload) => {
    const value = read(new TextDecoder().decode(payload));
    if (value === null) throw new DamagedMessage("no JSON object of its kind");
    return apply(model, value);
  };
}

/** The list after a change; null where entries between the known and the given ones are missing. */
export function changed<T extends { id: number }>(
  list: T[],
  { count, entries }: json.ListChange<T>,
): T[] | null {
  const now = list.slice(0, count);
  for (const entry of entries) {
    if (!(Number.isInteger(entry.id) && entry.id >= 0 && entry.id < count)) continue;
    if (entry.id > now.length) return null;
    now[entry.id] = entry;
  }
  return now.length === count ? now : null;
}

function takeTrajectory(model: Model, given: cdr.Trajectory): boolean {
  if (!model.track.replace(given)) return false;
  model.trackVersion++;
  model.changed("trajectory");
  return true;
}

const kCdr: Record<string, Reader> = {
  "/tf": (model, payload) => model.addTransforms(cdr.readTransforms(payload), false),
  "/tf_static": (model, payload) => model.addTransforms(cdr.readTransforms(payload), true),
  "/pose": (model, payload) => {
    const given = cdr.readPoseWithCovariance(payload);
    model.setRobot(given.pose, given.covariance, given.yawVariance);
  },
  "/particles": (model, payload) => {
    model.particles = cdr.readPoseArray(payload);
    model.changed("particles");
  },
  "/map": (model, payload) => {
    model.mapSink?.setGrid(cdr.readOccupancyGrid(payload));
    model.changed("map");
  },
  "/path": (model, payload) => takeTrajectory(model, cdr.readPath(payload)),
  "/loopstone/tiles": (model, payload) => {
    model.mapSink?.addTiles(cdr.readMapTiles(payload));
    if (model.mapSink?.full) model.note("The map is larger than this page can draw.");
    model.changed("map");
  },
  "/loopstone/trajectory": (model, payload) => takeTrajectory(model, cdr.readTrajectory(payload)),
};

const kJson: Record<string, Reader> = {
  "/loopstone/status": ofJson(json.readStatus, (model, value) => model.setStatus(value)),
  "/loopstone/closures": ofJson(json.readClosures, (model, change) => {
    const closures = changed(model.closures, change);
    if (closures === null) return false;
    model.closures = closures;
    model.changed("closures");
    return true;
  }),
  "/loopstone/submaps": ofJson(json.readSubmaps, (model, change) => {
    const submaps = changed(model.submaps, change);
    if (submaps === null) return false;
    model.submaps = submaps;
    model.changed("submaps");
    return true;
  }),
  "/loopstone/verdict": ofJson(json.readVerdict, (model, value) => {
    model.verdict = value;
    model.changed("verdict");
  }),
  "/loopstone/warnings": ofJson(json.readWarnings, (model, value) => {
    model.warnings = value;
    model.changed("warnings");
  }),
  "/loopstone/quality": ofJson(json.readPicture, (model, { picture }) => {
    model.quality = picture;
    model.changed("quality");
  }),
  "/loopstone/texture": ofJson(json.readPicture, (model, { picture }) => {
    model.texture = picture;
    model.changed("texture");
  }),
};

/** A topic for each laser. */
const kScans = /^\/scan(_\d+)?$/;

/** Where a server has the topic on the left, the one on the right says the same in less detail. */
const kCoarser: Record<string, string> = {
  "/loopstone/tiles": "/map",
  "/loopstone/trajectory": "/path",
};

export function readerOf(channel: Channel): Reader | null {
  const { topic } = channel;
  if (channel.encoding === "cdr" && kScans.test(topic)) {
    return (model, payload) => model.setScan(topic, cdr.readLaserScan(payload));
  }
  if (channel.encoding === "cdr") return kCdr[topic] ?? null;
  if (channel.encoding === "json") return kJson[channel.topic] ?? null;
  return null;
}

/** Those of a server's channels that the page wants. */
export function wanted(channels: Channel[]): Channel[] {
  const known = channels.filter((channel) => readerOf(channel) !== null);
  const topics = new Set(known.map((channel) => channel.topic));
  const coarser = new Set(
    Object.entries(kCoarser)
      .filter(([fine]) => topics.has(fine))
      .map(([, coarse]) => coarse),
  );
  return known.filter((channel) => !coarser.has(channel.topic));
}

/** Reads a message and never throws; false where all of the channel is needed again. */
export function takeMessage(model: Model, channel: Channel, payload: Uint8Array): boolean {
  try {
    return readerOf(channel)?.(model, payload) !== false;
  } catch (error) {
    model.damaged++;
    const why = error instanceof Error ? error.message : String(error);
    model.note(`A message of ${channel.topic} could not be read: ${why}.`);
    return true;
  }
}
