/** The conversation with the server: connects, subscribes, reconnects, controls time. */
import { readAbout } from "./json_messages.ts";
import type { Model } from "./model.ts";
import * as protocol from "./protocol.ts";
import { takeMessage, wanted } from "./topics.ts";

/** What a session needs of the browser; tests bring their own. */
export interface Surroundings {
  open(url: string): WebSocket;
  fetch(url: string): Promise<{ ok: boolean; status: number; text(): Promise<string> }>;
  setTimeout(task: () => void, milliseconds: number): number;
  clearTimeout(timer: number): void;
  now(): number;
  random(): number;
}

const kFirstWait = 500;
const kLongestWait = 10_000;
/** An attempt that neither opens nor fails is given up. */
const kPatience = 8_000;
const kSeekInterval = 100;
const kSeekPatience = 5_000;

/** Waiting before the n-th attempt: doubled each time, with a part left to chance. */
export function waitBefore(attempt: number, random: number): number {
  return Math.min(kLongestWait, kFirstWait * 2 ** Math.min(attempt, 10)) * (0.75 + random / 4);
}

/** Where a page at `href` finds its socket and its interface; its query goes along. */
export function addressesOf(href: string): { socket: string; api: (path: string) => string } {
  const page = new URL(href);
  const base = new URL(".", page);
  const socket = new URL(base);
  socket.protocol = page.protocol === "https:" ? "wss:" : "ws:";
  socket.search = page.search;
  return {
    socket: socket.href,
    api: (path) => {
      const url = new URL(path, base);
      url.search = page.search;
      return url.href;
    },
  };
}

export class Session {
  readonly api: (path: string) => string;
  private readonly url: string;
  private socket: WebSocket | null = null;
  private timer = 0;
  private attempt = 0;
  private sessionId: string | null = null;
  private channels = new Map<number, protocol.Channel>();
  private readonly subscriptions = new Map<number, protocol.Channel>();
  private nextSubscription = 1;
  private nextRequest = 1;
  private pendingSeek: { request: string; since: number } | null = null;
  private seekTimer = 0;
  private seekTarget: number | null = null;

  constructor(
    private readonly model: Model,
    href: string,
    private readonly around: Surroundings,
  ) {
    const addresses = addressesOf(href);
    this.url = addresses.socket;
    this.api = addresses.api;
  }

  connect(): void {
    this.around.clearTimeout(this.timer);
    this.drop();
    this.model.connection = { state: "connecting" };
    this.model.changed("connection");
    let socket: WebSocket;
    try {
      socket = this.around.open(this.url);
    } catch {
      this.lost();
      return;
    }
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    const mine = (task: () => void) => () => (this.socket === socket ? task() : undefined);
    socket.onopen = mine(() => this.opened());
    socket.onclose = mine(() => this.lost());
    socket.onerror = () => undefined; // a close follows
    socket.onmessage = (event: MessageEvent<unknown>) => {
      if (this.socket === socket) this.received(event.data);
    };
    this.timer = this.around.setTimeout(
      mine(() => this.lost()),
      kPatience,
    );
  }

  private opened(): void {
    this.around.clearTimeout(this.timer);
    this.attempt = 0;
    this.model.connection = { state: "open" };
    this.model.changed("connection");
    void this.askAbout();
  }

  private lost(): void {
    this.drop();
    const wait = waitBefore(this.attempt++, this.around.random());
    this.model.connection = { state: "lost", retryAt: this.around.now() + wait };
    this.model.changed("connection");
    this.around.clearTimeout(this.timer);
    this.timer = this.around.setTimeout(() => this.connect(), wait);
    void this.askWhetherRefused();
  }

  private drop(): void {
    const socket = this.socket;
    this.socket = null;
    this.subscriptions.clear();
    this.channels.clear();
    this.pendingSeek = null;
    if (socket !== null && socket.readyState <= 1) socket.close();
  }

  /** A browser does not tell why a socket was refused; the interface on the same port does. */
  private async askWhetherRefused(): Promise<void> {
    try {
      const { status } = await this.around.fetch(this.api("api/about"));
      const { connection } = this.model;
      if ((status !== 401 && status !== 403) || connection.state !== "lost") return;
      const reason = "The server refuses this page: the token is missing or wrong.";
      this.model.connection = { state: "refused", retryAt: connection.retryAt, reason };
      this.model.changed("connection");
    } catch {
      // Nobody answers: the connection is lost, and that is said already.
    }
  }

  private async askAbout(): Promise<void> {
    try {
      const answer = await this.around.fetch(this.api("api/about"));
      const about = answer.ok ? readAbout(await answer.text()) : null;
      if (about === null) return;
      this.model.about = about;
      this.model.changed("about");
    } catch {
      // The page does without; the socket tells the rest.
    }
  }

  private received(data: unknown): void {
    this.model.received++;
    if (typeof data === "string") {
      const operation = protocol.parseOperation(data);
      if (operation !== null) this.takeOperation(operation);
    } else if (data instanceof ArrayBuffer) {
      const frame = protocol.decodeFrame(data);
      if (frame !== null) this.takeFrame(frame);
    }
  }

  private takeOperation(operation: protocol.Operation): void {
    switch (operation.op) {
      case "serverInfo":
        this.takeServerInfo(operation);
        break;
      case "advertise":
        for (const channel of operation.channels) this.channels.set(channel.id, channel);
        this.reconcile();
        break;
      case "unadvertise":
        for (const id of operation.channelIds) this.channels.delete(id);
        for (const [subscription, channel] of this.subscriptions) {
          if (!this.channels.has(channel.id)) this.subscriptions.delete(subscription);
        }
        break;
      case "status":
        this.model.note(operation.message);
        break;
    }
  }

  private takeServerInfo(info: protocol.ServerInfo): void {
    // Whatever comes next is of the same run only if the server says so.
    const same = info.session !== "" && info.session === this.sessionId;
    if (this.sessionId !== null && !same) {
      const about = this.model.about;
      this.model.reset();
      this.model.about = about;
    }
    this.sessionId = info.session;
    this.model.serverName = info.name;
    this.model.start = info.dataStart;
    this.model.end = info.dataEnd;
    this.model.canSeek =
      info.capabilities.includes("playbackControl") &&
      info.dataStart !== null &&
      info.dataEnd !== null;
    this.model.changed("playback");
  }

  /** Subscribes to what is wanted of all that is advertised, and to nothing else. */
  private reconcile(): void {
    const channels = wanted([...this.channels.values()]);
    const ids = new Set(channels.map((channel) => channel.id));
    const surplus = [...this.subscriptions].filter(([, channel]) => !ids.has(channel.id));
    for (const [subscription] of surplus) this.subscriptions.delete(subscription);
    const subscriptionIds = surplus.map(([subscription]) => subscription);
    if (surplus.length > 0) this.send(JSON.stringify({ op: "unsubscribe", subscriptionIds }));
    const already = new Set([...this.subscriptions.values()].map((channel) => channel.id));
    this.subscribe(channels.filter((channel) => !already.has(channel.id)));
  }

  private subscribe(channels: protocol.Channel[]): void {
    const subscriptions = channels.map((channel) => {
      const id = this.nextSubscription++;
      this.subscriptions.set(id, channel);
      return { id, channelId: channel.id };
    });
    if (subscriptions.length > 0) this.send(JSON.stringify({ op: "subscribe", subscriptions }));
  }

  /** Subscribes anew, and so gets all of a topic again. */
  askAgain(topic: string): void {
    for (const [id, channel] of this.subscriptions) {
      if (channel.topic !== topic) continue;
      this.subscriptions.delete(id);
      this.send(JSON.stringify({ op: "unsubscribe", subscriptionIds: [id] }));
      this.subscribe([channel]);
      return;
    }
  }

  private takeFrame(frame: protocol.ServerFrame): void {
    switch (frame.kind) {
      case "message": {
        const channel = this.subscriptions.get(frame.subscription);
        if (channel === undefined) return;
        if (!takeMessage(this.model, channel, frame.payload)) this.askAgain(channel.topic);
        break;
      }
      case "time":
        if (!this.seeking) this.model.setTime(frame.time);
        break;
      case "playback":
        this.takePlayback(frame);
        break;
    }
  }

  private takePlayback(frame: protocol.PlaybackFrame): void {
    if (this.pendingSeek?.request === frame.request || frame.didSeek) this.pendingSeek = null;
    this.model.playback = frame.status;
    this.model.speed = frame.speed;
    if (!this.seeking) this.model.setTime(frame.time);
    this.model.changed("playback");
  }

  /** Whether the shown time is one that was asked for and has not been reached. */
  private get seeking(): boolean {
    if (this.seekTarget !== null) return true;
    const pending = this.pendingSeek;
    return pending !== null && this.around.now() - pending.since < kSeekPatience;
  }

  play(playing: boolean): void {
    const fromStart = playing && this.model.playback === "ended" ? this.model.start : null;
    if (fromStart !== null) this.model.setTime(fromStart);
    this.control(playing, this.model.speed, fromStart);
  }

  setSpeed(speed: number): void {
    this.control(this.playing, speed, null);
  }

  get playing(): boolean {
    return this.model.playback === "playing" || this.model.playback === "buffering";
  }

  /** Shown at once; sent at most ten times a second, the last one always. */
  seek(time: number): void {
    const { start, end } = this.model;
    if (!this.model.canSeek || start === null || end === null) return;
    this.seekTarget = Math.min(end, Math.max(start, time));
    this.model.setTime(this.seekTarget);
    if (this.seekTimer === 0) this.sendSeek();
  }

  private sendSeek(): void {
    this.seekTimer = 0;
    if (this.seekTarget === null) return;
    const target = this.seekTarget;
    this.seekTarget = null;
    this.control(this.playing, this.model.speed, target);
    this.seekTimer = this.around.setTimeout(() => this.sendSeek(), kSeekInterval);
  }

  private control(play: boolean, speed: number, seek: number | null): void {
    const request = `page-${this.nextRequest++}`;
    if (seek !== null) this.pendingSeek = { request, since: this.around.now() };
    // Taken as done, so that what is asked next does not undo it; the server's answer corrects it.
    this.model.playback = play ? "playing" : "paused";
    this.model.speed = speed;
    this.model.changed("playback");
    this.send(protocol.encodePlaybackControl({ play, speed, seek, request }));
  }

  private send(data: string | ArrayBuffer): void {
    if (this.socket?.readyState === 1) this.socket.send(data);
  }
}
