/** A server that speaks the page's wire, with a run made by code. */
import { createServer, type IncomingMessage, type Server, type ServerResponse } from "node:http";
import type { AddressInfo } from "node:net";
import { type WebSocket, WebSocketServer } from "ws";
import { compose, inverse, type Pose } from "../src/geometry.ts";
import { nanosecondsOf, secondsOf } from "../src/protocol.ts";
import { BadRequest } from "./edited.ts";
import { DemoEdits } from "./edits.ts";
import * as wire from "./messages.ts";
import { Random } from "./random.ts";
import { type Node, pointsAt, type Run, scanAt } from "./run.ts";

export interface Options {
  mode: "replay" | "mapping" | "localizing";
  /** Bytes of the page. */
  page: Buffer;
  token: string | null;
  canSeek: boolean;
  playing: boolean;
  /** Whether the run can be edited, and how long drawing its map takes [ms]. */
  edit?: boolean;
  drawDelay?: number;
}

interface Channel {
  id: number;
  topic: string;
  encoding: "cdr" | "json";
  schemaName: string;
  schema: string;
  schemaEncoding: string;
}

const kTopics: [string, "cdr" | "json", string][] = [
  ["/tf", "cdr", "tf2_msgs/msg/TFMessage"],
  ["/tf_static", "cdr", "tf2_msgs/msg/TFMessage"],
  ["/scan", "cdr", "sensor_msgs/msg/LaserScan"],
  ["/pose", "cdr", "geometry_msgs/msg/PoseWithCovarianceStamped"],
  ["/map", "cdr", "nav_msgs/msg/OccupancyGrid"],
  ["/path", "cdr", "nav_msgs/msg/Path"],
  ["/graph", "cdr", "visualization_msgs/msg/MarkerArray"],
  ["/particles", "cdr", "geometry_msgs/msg/PoseArray"],
  ["/loopstone/tiles", "cdr", "loopstone_msgs/msg/MapTiles"],
  ["/loopstone/trajectory", "cdr", "loopstone_msgs/msg/Trajectory"],
  ["/loopstone/status", "json", "loopstone.Status"],
  ["/loopstone/closures", "json", "loopstone.Closures"],
  ["/loopstone/submaps", "json", "loopstone.Submaps"],
  ["/loopstone/verdict", "json", "loopstone.Verdict"],
  ["/loopstone/warnings", "json", "loopstone.Warnings"],
  ["/loopstone/quality", "json", "loopstone.Picture"],
  ["/loopstone/texture", "json", "loopstone.Picture"],
];

const kMount: Pose = { x: 0.2, y: 0, yaw: 0 };
const kTick = 33;
const kMostBytes = 64 * 1024;
const kDrawDelay = 1200;

class Client {
  readonly subscriptions = new Map<string, number>();
  constructor(readonly socket: WebSocket) {}

  publish(topic: string, time: number, payload: Uint8Array): void {
    const subscription = this.subscriptions.get(topic);
    if (subscription === undefined) return;
    const frame = Buffer.alloc(13 + payload.length);
    frame.writeUInt8(1, 0);
    frame.writeUInt32LE(subscription, 1);
    frame.writeBigUInt64LE(nanosecondsOf(time), 5);
    frame.set(payload, 13);
    this.socket.send(frame);
  }

  publishJson(topic: string, time: number, json: object): void {
    this.publish(topic, time, Buffer.from(JSON.stringify(json)));
  }
}

export class DemoServer {
  time: number;
  speed = 1;
  status: 0 | 1 | 3 = 0;
  /** What clients asked for, newest last. */
  readonly controls: { play: boolean; speed: number; seek: number | null }[] = [];
  /** Addresses that were asked for over HTTP, and those of sockets. */
  readonly requests: string[] = [];
  sessionId = "demo-1";
  /** Null where nobody may edit. */
  readonly edits: DemoEdits | null;
  private readonly http: Server;
  private readonly sockets: WebSocketServer;
  private readonly clients = new Set<Client>();
  private readonly channels: Channel[];
  private readonly scans = new Map<number, number[]>();
  private readonly random = new Random(5);
  private timer: NodeJS.Timeout | null = null;
  private shown = -1;
  private ticks = 0;

  constructor(
    readonly run: Run,
    readonly options: Options,
  ) {
    this.time = this.begin;
    const delay = options.drawDelay ?? kDrawDelay;
    const publish = (topics: string[]) => this.sendAgain(topics);
    this.edits = options.edit === true ? new DemoEdits(run, delay, publish) : null;
    this.status = options.playing ? 0 : 1;
    const skipped = options.mode === "localizing" ? [] : ["/particles"];
    this.channels = kTopics
      .filter(([topic]) => !skipped.includes(topic))
      .map(([topic, encoding, schemaName], i) => ({
        id: 101 + i,
        topic,
        encoding,
        schemaName,
        schema: encoding === "json" ? '{"type":"object"}' : "",
        schemaEncoding: encoding === "json" ? "jsonschema" : "ros2msg",
      }));
    this.http = createServer((request, response) => this.answer(request, response));
    this.sockets = new WebSocketServer({
      server: this.http,
      verifyClient: ({ req }: { req: IncomingMessage }) => this.allowed(req),
      handleProtocols: (offered) =>
        offered.has("foxglove.websocket.v1") ? "foxglove.websocket.v1" : false,
      perMessageDeflate: false,
    });
    this.sockets.on("connection", (socket) => this.greet(socket));
  }

  get begin(): number {
    return this.run.nodes[0]?.t ?? 0;
  }

  get end(): number {
    return this.run.nodes[this.run.nodes.length - 1]?.t ?? 0;
  }

  get port(): number {
    return (this.http.address() as AddressInfo).port;
  }

  get url(): string {
    const query = this.options.token === null ? "" : `?token=${this.options.token}`;
    return `http://127.0.0.1:${this.port}/${query}`;
  }

  listen(port = 0): Promise<void> {
    this.timer = setInterval(() => this.tick(), kTick);
    return new Promise((resolve) => this.http.listen(port, "127.0.0.1", resolve));
  }

  async close(): Promise<void> {
    if (this.timer !== null) clearInterval(this.timer);
    this.edits?.close();
    this.dropClients();
    this.sockets.close();
    this.http.closeAllConnections();
    await new Promise((resolve) => this.http.close(resolve));
  }

  dropClients(): void {
    for (const { socket } of this.clients) socket.terminate();
  }

  /** Bytes to all that listen, whatever they are. */
  sendRaw(bytes: Uint8Array | string): void {
    for (const { socket } of this.clients) socket.send(bytes);
  }

  publish(topic: string, payload: Uint8Array): void {
    for (const client of this.clients) client.publish(topic, this.time, payload);
  }

  private allowed(request: IncomingMessage): boolean {
    this.requests.push(request.url ?? "");
    const url = new URL(request.url ?? "/", "http://localhost");
    return this.options.token === null || url.searchParams.get("token") === this.options.token;
  }

  private answer(request: IncomingMessage, response: ServerResponse): void {
    const path = new URL(request.url ?? "/", "http://localhost").pathname;
    const json = (status: number, body: object) => {
      response.writeHead(status, { "content-type": "application/json" }).end(JSON.stringify(body));
    };
    const allowed = this.allowed(request);
    if (path === "/") {
      response
        .writeHead(200, { "content-type": "text/html; charset=utf-8" })
        .end(this.options.page);
    } else if (!allowed) {
      json(403, { error: "the token is missing or wrong" });
    } else if (path === "/api/about") {
      const { mode, canSeek } = this.options;
      json(200, {
        program: "loopstone",
        version: "demo",
        mode,
        name: this.run.name,
        can_seek: canSeek,
        can_edit: this.edits !== null,
      });
    } else if (path.startsWith("/api/edits")) {
      this.answerEdits(request, path, json);
    } else if (/^\/api\/nodes\/\d+\/scan$/.test(path)) {
      const node = this.run.nodes[Number(path.split("/")[3])];
      if (node === undefined) json(404, { error: "no such node" });
      else json(200, { t: node.t, points: pointsAt(this.run.walls, node.pose) });
    } else if (path.startsWith("/api/closures/")) {
      const evidence = this.evidence(Number(path.slice("/api/closures/".length)));
      if (evidence === null) json(404, { error: "no such closure" });
      else json(200, evidence);
    } else {
      json(404, { error: "there is no such page" });
    }
  }

  private answerEdits(
    request: IncomingMessage,
    path: string,
    json: (status: number, body: object) => void,
  ): void {
    const { edits } = this;
    if (edits === null) return json(403, { error: "this folder cannot be edited" });
    if (request.method !== "POST") return json(200, edits.state());
    const parts: Buffer[] = [];
    request.on("data", (part: Buffer) => parts.push(part));
    request.on("end", () => {
      const body = Buffer.concat(parts);
      if (body.length > kMostBytes) return json(413, { error: "more than 64 KiB" });
      if (request.headers["content-type"] !== "application/json")
        return json(400, { error: "Content-Type must be application/json" });
      try {
        json(200, edits.post(path, JSON.parse(body.toString())));
      } catch (error) {
        const status = error instanceof BadRequest ? error.status : 400;
        json(status, { error: error instanceof Error ? error.message : String(error) });
      }
    });
  }

  private sendAgain(topics: string[]): void {
    for (const client of this.clients) {
      for (const topic of topics) this.sendLast(client, topic);
    }
    this.shown = -1;
  }

  private get nodes(): Node[] {
    return this.edits?.nodes ?? this.run.nodes;
  }

  private get closures() {
    return this.edits?.closures ?? this.run.closures;
  }

  private evidence(id: number): object | null {
    // One that is shown still may be of before the run began anew.
    const closure = this.closuresNow()[id] ?? this.closures[id];
    if (closure === undefined) return null;
    const from = this.run.nodes[closure.from] as Node;
    const to = this.run.nodes[closure.to] as Node;
    const list = ({ x, y, yaw }: Pose) => [x, y, yaw];
    return {
      id,
      from: { t: from.t, points: pointsAt(this.run.walls, from.pose) },
      to: { t: to.t, points: pointsAt(this.run.walls, to.pose) },
      measured: list(closure.measured),
      graph: list(compose(inverse(from.pose), to.pose)),
    };
  }

  private greet(socket: WebSocket): void {
    const client = new Client(socket);
    this.clients.add(client);
    socket.on("close", () => this.clients.delete(client));
    socket.on("error", () => socket.terminate());
    const { canSeek } = this.options;
    const stamp = (t: number) => ({ sec: Math.floor(t), nsec: Math.round((t % 1) * 1e9) });
    const bounds = canSeek
      ? { dataStartTime: stamp(this.begin), dataEndTime: stamp(this.end) }
      : {};
    socket.send(
      JSON.stringify({
        op: "serverInfo",
        name: "loopstone demo",
        capabilities: canSeek ? ["time", "playbackControl"] : ["time"],
        supportedEncodings: [],
        sessionId: this.sessionId,
        ...bounds,
      }),
    );
    socket.send(JSON.stringify({ op: "advertise", channels: this.channels }));
    if (canSeek) this.sendPlayback([client], false, "");
    socket.on("message", (data, binary) => this.take(client, data as Buffer, binary));
  }

  private take(client: Client, data: Buffer, binary: boolean): void {
    if (binary) {
      this.takeControl(data);
      return;
    }
    const message = JSON.parse(data.toString()) as {
      op: string;
      subscriptions?: { id: number; channelId: number }[];
      subscriptionIds?: number[];
    };
    for (const { id, channelId } of message.op === "subscribe"
      ? (message.subscriptions ?? [])
      : []) {
      const channel = this.channels.find((one) => one.id === channelId);
      if (channel === undefined) continue;
      client.subscriptions.set(channel.topic, id);
      this.sendLast(client, channel.topic);
    }
    if (message.op === "unsubscribe") {
      for (const [topic, id] of client.subscriptions) {
        if (message.subscriptionIds?.includes(id)) client.subscriptions.delete(topic);
      }
    }
  }

  private takeControl(data: Buffer): void {
    if (data[0] !== 3 || data.length < 19) return;
    const play = data[1] === 0;
    const speed = data.readFloatLE(2);
    const seek = data[6] === 0 ? null : secondsOf(data.readBigUInt64LE(7));
    const request = data.subarray(19).toString();
    this.controls.push({ play, speed, seek });
    this.status = play ? 0 : 1;
    this.speed = speed;
    if (seek !== null) this.time = Math.min(this.end, Math.max(this.begin, seek));
    if (seek !== null) this.shown = -1;
    this.sendPlayback(this.clients, seek !== null, request);
    this.sendNow(true);
  }

  private sendPlayback(to: Iterable<Client>, didSeek: boolean, request: string): void {
    const id = Buffer.from(request);
    const frame = Buffer.alloc(19 + id.length);
    frame.writeUInt8(5, 0);
    frame.writeUInt8(this.status, 1);
    frame.writeBigUInt64LE(nanosecondsOf(this.time), 2);
    frame.writeFloatLE(this.speed, 10);
    frame.writeUInt8(didSeek ? 1 : 0, 14);
    frame.writeUInt32LE(id.length, 15);
    frame.set(id, 19);
    for (const { socket } of to) socket.send(frame);
  }

  /** Nodes known by now: all of them of a finished run. */
  private get known(): number {
    return this.options.mode === "mapping" ? this.nodeNow + 1 : this.run.nodes.length;
  }

  private get nodeNow(): number {
    const { nodes } = this.run;
    let below = 0;
    let above = nodes.length - 1;
    while (below < above) {
      const middle = (below + above + 1) >> 1;
      if ((nodes[middle]?.t ?? 0) <= this.time + 1e-6) below = middle;
      else above = middle - 1;
    }
    return below;
  }

  private closuresNow() {
    const { known } = this;
    return this.closures.filter((one) => one.to < known);
  }

  /** What a new subscriber gets. */
  private sendLast(client: Client, topic: string): void {
    const { run, time } = this;
    const finished = this.options.mode === "replay";
    // The floor is not painted anew in another frame.
    const shown = (picture: object) => (this.edits?.moved ? { ...picture, png: "" } : picture);
    const send: Record<string, () => void> = {
      "/tf_static": () =>
        client.publish(topic, time, wire.transforms(time, [["base_link", "laser", kMount]])),
      "/loopstone/tiles": () =>
        client.publish(topic, time, wire.mapTiles(run, this.edits?.tiles ?? run.tiles(), true)),
      "/loopstone/trajectory": () =>
        client.publish(topic, time, wire.trajectory(this.nodes, 0, this.known)),
      "/loopstone/closures": () =>
        client.publishJson(topic, time, wire.closures(this.nodes, this.closuresNow())),
      "/loopstone/submaps": () =>
        client.publishJson(topic, time, wire.submaps(run.nodes.slice(0, this.known))),
      "/loopstone/verdict": () =>
        finished && client.publishJson(topic, time, this.edits?.verdict ?? wire.kVerdict),
      "/loopstone/warnings": () => client.publishJson(topic, time, wire.warnings(this.begin)),
      "/loopstone/quality": () =>
        run.quality && client.publishJson(topic, time, shown(run.quality)),
      "/loopstone/texture": () =>
        run.texture && client.publishJson(topic, time, shown(run.texture)),
      "/pose": () => (this.shown = -1),
    };
    send[topic]?.();
  }

  private tick(): void {
    this.ticks++;
    if (this.status !== 0) return this.sendNow(false);
    this.time += (kTick / 1000) * (this.speed > 0 ? this.speed : 200);
    if (this.time >= this.end) {
      this.time = this.end;
      this.status = 3;
      this.sendPlayback(this.clients, false, "");
    }
    this.sendNow(false);
  }

  private sendNow(always: boolean): void {
    const at = this.nodeNow;
    const moved = at !== this.shown;
    const node = this.nodes[at];
    if (node === undefined || this.clients.size === 0 || !(moved || always)) return;
    const time = Buffer.alloc(9);
    time.writeUInt8(2, 0);
    time.writeBigUInt64LE(nanosecondsOf(this.time), 1);
    for (const { socket } of this.clients) socket.send(time);
    const before = this.shown;
    this.shown = at;
    for (const client of this.clients) this.sendNode(client, node, at, before);
  }

  private sendNode(client: Client, node: Node, at: number, before: number): void {
    const { mode } = this.options;
    const localizing = mode === "localizing";
    client.publish("/tf", node.t, wire.transforms(node.t, [["map", "base_link", node.pose]]));
    client.publish("/pose", node.t, wire.poseWithCovariance(node.t, node.pose, node.sigma));
    client.publish("/scan", node.t, wire.laserScan(node.t, this.scanOf(at, node)));
    client.publishJson(
      "/loopstone/status",
      node.t,
      wire.status(this.run, node, at, this.known, localizing),
    );
    if (localizing) client.publish("/particles", node.t, wire.particles(node.t, this.cloud(node)));
    if (mode !== "mapping") return;
    const first = Math.max(0, Math.min(before, at));
    const nodes = wire.trajectory(this.run.nodes, before < 0 || at < before ? 0 : first, at + 1);
    client.publish("/loopstone/trajectory", node.t, nodes);
    if (this.ticks % 15 === 0) {
      client.publishJson(
        "/loopstone/closures",
        node.t,
        wire.closures(this.run.nodes, this.closuresNow()),
      );
      client.publishJson(
        "/loopstone/submaps",
        node.t,
        wire.submaps(this.run.nodes.slice(0, at + 1)),
      );
    }
  }

  private scanOf(at: number, node: Node): number[] {
    let ranges = this.scans.get(at);
    if (ranges === undefined) {
      const { pose } = this.run.nodes[at] ?? node;
      ranges = scanAt(this.run.walls, compose(pose, kMount));
      if (this.scans.size < 5000) this.scans.set(at, ranges);
    }
    return ranges;
  }

  private cloud(node: Node): Pose[] {
    return Array.from({ length: 500 }, () => ({
      x: node.pose.x + this.random.normal(0.15),
      y: node.pose.y + this.random.normal(0.1),
      yaw: node.pose.yaw + this.random.normal(0.06),
    }));
  }
}
