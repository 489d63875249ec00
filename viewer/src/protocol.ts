/** Foxglove's WebSocket protocol, version 1: its frames and operations. Times in seconds. */
import { isObject, numberOf, parseObject, textOf } from "./json.ts";

export const kSubProtocols = ["foxglove.websocket.v1"];

export interface MessageFrame {
  kind: "message";
  subscription: number;
  time: number;
  payload: Uint8Array;
}

export interface TimeFrame {
  kind: "time";
  time: number;
}

export type PlaybackStatus = "playing" | "paused" | "buffering" | "ended";

export interface PlaybackFrame {
  kind: "playback";
  status: PlaybackStatus;
  time: number;
  speed: number;
  didSeek: boolean;
  request: string;
}

export type ServerFrame = MessageFrame | TimeFrame | PlaybackFrame;

const kStatuses: PlaybackStatus[] = ["playing", "paused", "buffering", "ended"];

/** Seconds of a double hold a date to better than a microsecond. */
export function secondsOf(nanoseconds: bigint): number {
  const whole = nanoseconds / 1_000_000_000n;
  return Number(whole) + Number(nanoseconds - whole * 1_000_000_000n) * 1e-9;
}

export function nanosecondsOf(seconds: number): bigint {
  if (!(seconds > 0) || !Number.isFinite(seconds)) return 0n;
  const whole = Math.floor(seconds);
  return BigInt(whole) * 1_000_000_000n + BigInt(Math.round((seconds - whole) * 1e9));
}

/** Null for what is damaged or of a kind that we do not know. */
export function decodeFrame(buffer: ArrayBuffer): ServerFrame | null {
  const view = new DataView(buffer);
  if (view.byteLength < 1) return null;
  switch (view.getUint8(0)) {
    case 1:
      if (view.byteLength < 13) return null;
      return {
        kind: "message",
        subscription: view.getUint32(1, true),
        time: secondsOf(view.getBigUint64(5, true)),
        payload: new Uint8Array(buffer, 13),
      };
    case 2:
      if (view.byteLength < 9) return null;
      return { kind: "time", time: secondsOf(view.getBigUint64(1, true)) };
    case 5:
      return decodePlayback(view);
    default:
      return null;
  }
}

function decodePlayback(view: DataView): PlaybackFrame | null {
  if (view.byteLength < 19) return null;
  const status = kStatuses[view.getUint8(1)];
  const length = view.getUint32(15, true);
  if (status === undefined || length > view.byteLength - 19) return null;
  const speed = view.getFloat32(10, true);
  return {
    kind: "playback",
    status,
    time: secondsOf(view.getBigUint64(2, true)),
    speed: Number.isFinite(speed) ? speed : 1,
    didSeek: view.getUint8(14) !== 0,
    request: new TextDecoder().decode(new Uint8Array(view.buffer, view.byteOffset + 19, length)),
  };
}

export interface PlaybackControl {
  play: boolean;
  speed: number;
  /** Where to go [s], if anywhere. */
  seek: number | null;
  request: string;
}

export function encodePlaybackControl(control: PlaybackControl): ArrayBuffer {
  const id = new TextEncoder().encode(control.request);
  const buffer = new ArrayBuffer(19 + id.length);
  const view = new DataView(buffer);
  view.setUint8(0, 3);
  view.setUint8(1, control.play ? 0 : 1);
  view.setFloat32(2, control.speed, true);
  view.setUint8(6, control.seek === null ? 0 : 1);
  view.setBigUint64(7, control.seek === null ? 0n : nanosecondsOf(control.seek), true);
  view.setUint32(15, id.length, true);
  new Uint8Array(buffer, 19).set(id);
  return buffer;
}

export interface Channel {
  id: number;
  topic: string;
  encoding: string;
  schemaName: string;
}

export interface ServerInfo {
  op: "serverInfo";
  name: string;
  capabilities: string[];
  session: string;
  dataStart: number | null;
  dataEnd: number | null;
}

export type Operation =
  | ServerInfo
  | { op: "advertise"; channels: Channel[] }
  | { op: "unadvertise"; channelIds: number[] }
  | { op: "status"; level: number; message: string };

/** A time as {sec, nsec}, or as nanoseconds in a number or a text. */
export function timeOf(value: unknown): number | null {
  if (isObject(value)) {
    const seconds = numberOf(value["sec"]);
    const nanoseconds = numberOf(value["nsec"] ?? value["nanosec"]) ?? 0;
    return seconds === null ? null : seconds + nanoseconds * 1e-9;
  }
  if (typeof value === "number" && Number.isFinite(value)) return value * 1e-9;
  if (typeof value === "string" && /^\d{1,19}$/.test(value)) return secondsOf(BigInt(value));
  return null;
}

function channelOf(value: unknown): Channel | null {
  if (!isObject(value) || typeof value["id"] !== "number" || typeof value["topic"] !== "string") {
    return null;
  }
  return {
    id: value["id"],
    topic: value["topic"],
    encoding: textOf(value["encoding"]),
    schemaName: textOf(value["schemaName"]),
  };
}

/** Null for what is damaged, or of no interest to us. */
export function parseOperation(text: string): Operation | null {
  const json = parseObject(text);
  if (json === null) return null;
  const list = (key: string): unknown[] => (Array.isArray(json[key]) ? json[key] : []);
  switch (json["op"]) {
    case "serverInfo":
      return {
        op: "serverInfo",
        name: textOf(json["name"]),
        capabilities: list("capabilities").map(textOf),
        session: textOf(json["sessionId"]),
        dataStart: timeOf(json["dataStartTime"]),
        dataEnd: timeOf(json["dataEndTime"]),
      };
    case "advertise": {
      const channels = list("channels").map(channelOf);
      return { op: "advertise", channels: channels.filter((one) => one !== null) };
    }
    case "unadvertise":
      return {
        op: "unadvertise",
        channelIds: list("channelIds").map((one) => numberOf(one) ?? -1),
      };
    case "status":
      return {
        op: "status",
        level: numberOf(json["level"]) ?? 0,
        message: textOf(json["message"]),
      };
    default:
      return null;
  }
}
