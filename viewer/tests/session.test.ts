import assert from "node:assert/strict";
import { test } from "node:test";
import { Model } from "../src/model.ts";
import { addressesOf, Session, type Surroundings, waitBefore } from "../src/session.ts";
import { Random } from "../demo/random.ts";
import * as wire from "../demo/messages.ts";

class FakeSocket {
  readyState = 0;
  binaryType = "";
  readonly sent: (string | ArrayBuffer)[] = [];
  onopen: () => void = () => undefined;
  onclose: () => void = () => undefined;
  onerror: () => void = () => undefined;
  onmessage: (event: { data: unknown }) => void = () => undefined;

  send(data: string | ArrayBuffer): void {
    this.sent.push(data);
  }
  close(): void {
    this.readyState = 3;
  }
  open(): void {
    this.readyState = 1;
    this.onopen();
  }
  fail(): void {
    this.readyState = 3;
    this.onclose();
  }
  receive(data: unknown): void {
    this.onmessage({ data });
  }
  json(value: object): void {
    this.receive(JSON.stringify(value));
  }
  operations(
    op: string,
  ): { subscriptions: { id: number; channelId: number }[]; subscriptionIds: number[] }[] {
    return this.sent
      .filter((one) => typeof one === "string")
      .map((one) => JSON.parse(one))
      .filter((one) => one.op === op);
  }
}

function begin(status = 200) {
  const sockets: FakeSocket[] = [];
  const timers = new Map<number, { task: () => void; at: number }>();
  let now = 1000;
  let next = 1;
  const around: Surroundings = {
    open: () => {
      const socket = new FakeSocket();
      sockets.push(socket);
      return socket as unknown as WebSocket;
    },
    fetch: () =>
      Promise.resolve({ ok: status === 200, status, text: () => Promise.resolve('{"name":"a"}') }),
    setTimeout: (task, wait) => {
      timers.set(next, { task, at: now + wait });
      return next++;
    },
    clearTimeout: (timer) => timers.delete(timer),
    now: () => now,
    random: () => 1,
  };
  const model = new Model();
  const session = new Session(model, "http://localhost:8700/?token=abc", around);
  const advance = (wait: number) => {
    const end = now + wait;
    for (;;) {
      const due = [...timers]
        .filter(([, one]) => one.at <= end)
        .sort((a, b) => a[1].at - b[1].at)[0];
      if (due === undefined) break;
      timers.delete(due[0]);
      now = due[1].at;
      due[1].task();
    }
    now = end;
  };
  session.connect();
  const socket = () => sockets[sockets.length - 1] as FakeSocket;
  return { model, session, sockets, socket, advance };
}

const kChannel = (id: number, topic: string, encoding: string) => ({
  id,
  topic,
  encoding,
  schemaName: "",
});
const kInfo = {
  op: "serverInfo",
  name: "n",
  capabilities: ["time", "playbackControl"],
  sessionId: "one",
  dataStartTime: { sec: 10, nsec: 0 },
  dataEndTime: { sec: 20, nsec: 0 },
};

function frame(subscription: number, payload: Uint8Array): ArrayBuffer {
  const bytes = new Uint8Array(13 + payload.length);
  bytes[0] = 1;
  new DataView(bytes.buffer).setUint32(1, subscription, true);
  bytes.set(payload, 13);
  return bytes.buffer;
}

test("the page's query goes to the socket and to the interface", () => {
  const plain = addressesOf("http://localhost:8700/?token=a%20b#map");
  assert.equal(plain.socket, "ws://localhost:8700/?token=a%20b");
  assert.equal(plain.api("api/about"), "http://localhost:8700/api/about?token=a%20b");
  assert.equal(addressesOf("https://host/robot/").socket, "wss://host/robot/");
});

test("waiting doubles up to ten seconds", () => {
  assert.deepEqual(
    [0, 1, 2, 3, 4, 5, 50].map((n) => waitBefore(n, 1)),
    [500, 1000, 2000, 4000, 8000, 10_000, 10_000],
  );
  assert.ok(waitBefore(0, 0) >= 250);
});

test("what is known is subscribed to, once, and only the finer of two that say the same", () => {
  const { socket } = begin();
  socket().open();
  socket().json({
    op: "advertise",
    channels: [
      kChannel(1, "/map", "cdr"),
      kChannel(2, "/unknown", "cdr"),
      kChannel(3, "/pose", "json"),
    ],
  });
  assert.deepEqual(
    socket()
      .operations("subscribe")[0]
      ?.subscriptions.map((one) => one.channelId),
    [1],
  );
  socket().json({
    op: "advertise",
    channels: [kChannel(4, "/loopstone/tiles", "cdr"), kChannel(5, "/loopstone/status", "json")],
  });
  assert.equal(socket().operations("unsubscribe").length, 1);
  assert.deepEqual(
    socket()
      .operations("subscribe")[1]
      ?.subscriptions.map((one) => one.channelId),
    [4, 5],
  );
});

test("a lost connection is tried again, later each time, and soon again after it held", () => {
  const { model, sockets, socket, advance } = begin();
  socket().fail();
  assert.equal(model.connection.state, "lost");
  advance(499);
  assert.equal(sockets.length, 1);
  advance(1);
  assert.equal(sockets.length, 2);
  socket().fail();
  advance(999);
  assert.equal(sockets.length, 2);
  advance(1);
  assert.equal(sockets.length, 3);
  socket().open();
  assert.equal(model.connection.state, "open");
  socket().fail();
  advance(500);
  assert.equal(sockets.length, 4);
});

test("an attempt that neither opens nor fails is given up", () => {
  const { model, sockets, advance } = begin();
  advance(8000);
  assert.equal(model.connection.state, "lost");
  advance(500);
  assert.equal(sockets.length, 2);
});

test("an old socket has no say any more", () => {
  const { model, sockets, socket, advance } = begin();
  const old = socket();
  old.fail();
  advance(500);
  socket().open();
  old.onclose();
  old.receive("{}");
  assert.equal(sockets.length, 2);
  assert.equal(model.connection.state, "open");
});

test("a refused token is told as such", async () => {
  const { model, socket } = begin(403);
  socket().fail();
  await new Promise((resolve) => setImmediate(resolve));
  assert.equal(model.connection.state, "refused");
});

test("another run makes the page forget the one before; the same does not", () => {
  const { model, socket, advance } = begin();
  const again = (sessionId: string) => {
    socket().open();
    socket().json({ ...kInfo, sessionId });
  };
  again("one");
  model.closures = [{} as never];
  socket().fail();
  advance(500);
  again("one");
  assert.equal(model.closures.length, 1);
  socket().fail();
  advance(500);
  again("two");
  assert.equal(model.closures.length, 0);
});

const kNodes = Array.from({ length: 9 }, (_, i) => ({
  t: i,
  pose: { x: i, y: 0, yaw: 0 },
  sigma: 0,
  submap: 0,
  drive: 0,
  travelled: 0,
}));

test("a tail without what comes before it is asked for whole", () => {
  const { model, socket } = begin();
  socket().open();
  socket().json({ op: "advertise", channels: [kChannel(1, "/loopstone/trajectory", "cdr")] });
  const first = socket().operations("subscribe")[0]?.subscriptions[0]?.id ?? 0;
  socket().receive(frame(first, wire.trajectory(kNodes, 5, 9)));
  assert.equal(model.track.length, 0);
  assert.deepEqual(socket().operations("unsubscribe")[0]?.subscriptionIds, [first]);
  const second = socket().operations("subscribe")[1]?.subscriptions[0]?.id ?? 0;
  socket().receive(frame(second, wire.trajectory(kNodes, 0, 9)));
  socket().receive(frame(second, wire.trajectory(kNodes, 4, 6)));
  assert.equal(model.track.length, 6);
});

function controls(socket: FakeSocket) {
  return socket.sent
    .filter((one) => one instanceof ArrayBuffer)
    .map((one) => {
      const view = new DataView(one);
      return {
        play: view.getUint8(1) === 0,
        speed: view.getFloat32(2, true),
        seek: view.getUint8(6) === 0 ? null : Number(view.getBigUint64(7, true)) / 1e9,
      };
    });
}

test("dragging sends at most ten seeks a second, and the last one always", () => {
  const { model, session, socket, advance } = begin();
  socket().open();
  socket().json(kInfo);
  for (let i = 0; i <= 20; i++) {
    session.seek(10 + i / 2);
    advance(10);
  }
  advance(1000);
  const seeks = controls(socket()).map((one) => one.seek);
  assert.equal(seeks[0], 10);
  assert.equal(seeks[seeks.length - 1], 20);
  assert.ok(seeks.length <= 4, String(seeks));
  assert.equal(model.time, 20);
});

test("seeks stay within the run; play, speed and seek keep each other", () => {
  const { session, socket, advance } = begin();
  socket().open();
  socket().json(kInfo);
  session.seek(99);
  advance(200);
  session.setSpeed(5);
  session.play(false);
  session.seek(12);
  assert.deepEqual(controls(socket()), [
    { play: true, speed: 1, seek: 20 },
    { play: true, speed: 5, seek: null },
    { play: false, speed: 5, seek: null },
    { play: false, speed: 5, seek: 12 },
  ]);
});

test("whatever arrives, in frames or as text, the handler goes on", () => {
  const random = new Random(21);
  const { model, socket } = begin();
  socket().open();
  const topics = [
    "/tf",
    "/tf_static",
    "/scan",
    "/pose",
    "/particles",
    "/loopstone/trajectory",
    "/loopstone/tiles",
  ];
  const channels = topics.map((topic, i) => kChannel(i + 1, topic, "cdr"));
  const texts = ["status", "closures", "submaps", "verdict", "warnings", "quality", "texture"];
  channels.push(...texts.map((topic, i) => kChannel(20 + i, `/loopstone/${topic}`, "json")));
  socket().json({ op: "advertise", channels });
  const ids =
    socket()
      .operations("subscribe")[0]
      ?.subscriptions.map((one) => one.id) ?? [];
  for (let i = 0; i < 20_000; i++) {
    const payload = Uint8Array.from({ length: random.integer(120) }, () => random.integer(256));
    if (i % 2 === 0 && payload.length > 4) payload.set([0, 1, 0, 0]);
    socket().receive(frame(ids[random.integer(ids.length)] ?? 0, payload));
    socket().receive(payload.buffer.slice(0));
    socket().receive(String.fromCharCode(...payload));
  }
  socket().receive(undefined);
  socket().receive(new Blob([]));
  assert.ok(model.damaged > 1000);
  assert.ok(model.notes.length <= 50);
  assert.equal(model.connection.state, "open");
});
