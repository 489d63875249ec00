import assert from "node:assert/strict";
import { test } from "node:test";
import * as protocol from "../src/protocol.ts";
import * as json from "../src/json_messages.ts";
import { Model } from "../src/model.ts";
import { changed, takeMessage } from "../src/topics.ts";
import { Random } from "../demo/random.ts";

const bufferOf = (bytes: number[]) => Uint8Array.from(bytes).buffer;

test("a message's frame: subscription, time, payload", () => {
  const frame = new Uint8Array(15);
  const view = new DataView(frame.buffer);
  view.setUint8(0, 1);
  view.setUint32(1, 70_000, true);
  view.setBigUint64(5, 1_700_000_000_250_000_000n, true);
  frame.set([8, 9], 13);
  const read = protocol.decodeFrame(frame.buffer);
  assert.ok(read?.kind === "message");
  assert.equal(read.subscription, 70_000);
  assert.ok(Math.abs(read.time - 1_700_000_000.25) < 1e-6);
  assert.deepEqual([...read.payload], [8, 9]);
});

test("the state of playback", () => {
  const frame = new Uint8Array(22);
  const view = new DataView(frame.buffer);
  view.setUint8(0, 5);
  view.setUint8(1, 3);
  view.setBigUint64(2, 5_000_000_000n, true);
  view.setFloat32(10, 2.5, true);
  view.setUint8(14, 1);
  view.setUint32(15, 3, true);
  frame.set([97, 98, 99], 19);
  assert.deepEqual(protocol.decodeFrame(frame.buffer), {
    kind: "playback",
    status: "ended",
    time: 5,
    speed: 2.5,
    didSeek: true,
    request: "abc",
  });
  view.setUint32(15, 4, true);
  assert.equal(protocol.decodeFrame(frame.buffer), null, "a request id longer than the frame");
});

test("the control of playback is laid out as the protocol says", () => {
  const bytes = protocol.encodePlaybackControl({
    play: false,
    speed: 1.5,
    seek: 2.5,
    request: "x",
  });
  const view = new DataView(bytes);
  assert.equal(view.getUint8(0), 3);
  assert.equal(view.getUint8(1), 1);
  assert.equal(view.getFloat32(2, true), 1.5);
  assert.equal(view.getUint8(6), 1);
  assert.equal(view.getBigUint64(7, true), 2_500_000_000n);
  assert.equal(view.getUint32(15, true), 1);
  assert.equal(view.getUint8(19), 120);
  assert.equal(bytes.byteLength, 20);
});

test("nanoseconds and seconds", () => {
  for (const seconds of [0, 0.25, 1.5, 1_700_000_000.125]) {
    assert.equal(protocol.secondsOf(protocol.nanosecondsOf(seconds)), seconds);
  }
  for (const none of [-1, NaN, Infinity]) assert.equal(protocol.nanosecondsOf(none), 0n);
});

test("a time is read in every form that servers give it", () => {
  assert.equal(protocol.timeOf({ sec: 3, nsec: 500_000_000 }), 3.5);
  assert.equal(protocol.timeOf({ sec: 3, nanosec: 500_000_000 }), 3.5);
  assert.equal(protocol.timeOf(3_500_000_000), 3.5);
  assert.equal(protocol.timeOf("3500000000"), 3.5);
  for (const none of [null, undefined, "x", {}, [], NaN]) assert.equal(protocol.timeOf(none), null);
});

test("operations", () => {
  const info = protocol.parseOperation(
    '{"op":"serverInfo","name":"n","capabilities":["time"],"sessionId":"s","dataStartTime":{"sec":1,"nsec":0}}',
  );
  assert.ok(info?.op === "serverInfo");
  assert.equal(info.session, "s");
  assert.equal(info.dataStart, 1);
  assert.equal(info.dataEnd, null);
  const advertise = protocol.parseOperation(
    '{"op":"advertise","channels":[{"id":4,"topic":"/a","encoding":"cdr","schemaName":"S"},{"id":"x"},7]}',
  );
  assert.deepEqual(advertise, {
    op: "advertise",
    channels: [{ id: 4, topic: "/a", encoding: "cdr", schemaName: "S" }],
  });
});

test("random frames are read or refused, and nothing is thrown", () => {
  const random = new Random(1);
  for (let i = 0; i < 50_000; i++) {
    const bytes = Array.from({ length: random.integer(40) }, () => random.integer(256));
    if (bytes.length > 0) bytes[0] = [1, 2, 3, 5, 250][random.integer(5)] ?? 0;
    protocol.decodeFrame(bufferOf(bytes));
  }
});

/** Any JSON, with the keys that readers look for. */
function anything(random: Random, keys: string[], depth: number): unknown {
  const kind = random.integer(depth > 0 ? 9 : 6);
  if (kind === 0) return null;
  if (kind === 1) return random.next() < 0.5;
  if (kind === 2) return random.between(-1e3, 1e3);
  if (kind === 3) return 1e308 * 10 ** random.integer(2);
  if (kind === 4) return keys[random.integer(keys.length)];
  if (kind === 5) return "";
  if (kind === 6)
    return Array.from({ length: random.integer(5) }, () => anything(random, keys, depth - 1));
  const entries = Array.from({ length: random.integer(8) }, () => [
    keys[random.integer(keys.length)] as string,
    anything(random, keys, depth - 1),
  ]);
  return Object.fromEntries(entries);
}

const kKeys =
  "op serverInfo advertise unadvertise status name channels id topic encoding schemaName capabilities sessionId dataStartTime sec nsec channelIds level message closures from to state reason score figures submaps outline verdict places x y text warnings t png resolution measured graph points toString valueOf __proto__ constructor".split(
    " ",
  );

test("any JSON, and text that is none, gives a value of the right shape or null", () => {
  const random = new Random(3);
  const readers = [
    protocol.parseOperation,
    json.readClosures,
    json.readStatus,
    json.readSubmaps,
    json.readVerdict,
    json.readWarnings,
    json.readPicture,
    json.readAbout,
    json.readEvidence,
  ];
  for (let i = 0; i < 20_000; i++) {
    const value = anything(random, kKeys, 4);
    if (typeof value === "object" && value !== null && !Array.isArray(value) && i % 2 === 0) {
      Object.assign(value, {
        op: ["serverInfo", "advertise", "unadvertise", "status"][random.integer(4)],
      });
    }
    const text = JSON.stringify(value);
    for (const read of readers) {
      read(text);
      read(text.slice(0, random.integer(text.length + 1)));
    }
  }
});

test("closures keep what is known and take the rest as unknown", () => {
  const change = json.readClosures(
    '{"count":7,"closures":[{"id":1,"from":2,"to":3,"state":"revoked","score":0.5,"second_score":null},{"id":2},5]}',
  );
  assert.equal(change?.count, 7);
  const [one, ...more] = change?.entries ?? [];
  assert.equal(more.length, 0);
  assert.equal(one?.state, "revoked");
  assert.equal(one?.score, 0.5);
  assert.equal(one?.secondScore, null);
  assert.equal(one?.chi2, null);
});

test("a list takes changes, and asks for all of it where entries are missing", () => {
  const submaps = (count: number, ...ids: number[]) => ({
    count,
    entries: ids.map((id) => ({ id, state: "open" as const, outline: [count] })),
  });
  const first = changed([], submaps(3, 0, 1, 2));
  assert.deepEqual(
    first?.map(({ id }) => id),
    [0, 1, 2],
  );
  const second = changed(first ?? [], submaps(4, 1, 3));
  assert.deepEqual(
    second?.map(({ outline }) => outline[0]),
    [3, 4, 3, 4],
  );
  assert.equal(first?.[1]?.outline[0], 3, "who holds the old list keeps it");
  assert.equal(changed(second ?? [], submaps(2))?.length, 2);
  assert.equal(changed(second ?? [], submaps(6, 5)), null);
  assert.equal(changed(second ?? [], submaps(6)), null);
  assert.equal(changed([], submaps(1, 0, 7, -1, 0.5))?.length, 1);
  const model = new Model();
  const channel = { id: 1, topic: "/loopstone/closures", encoding: "json", schemaName: "" };
  const take = (text: string) => takeMessage(model, channel, new TextEncoder().encode(text));
  assert.equal(take('{"count":2,"closures":[{"id":1,"from":0,"to":1}]}'), false);
  assert.equal(take('{"count":1,"closures":[{"id":0,"from":0,"to":1}]}'), true);
  assert.equal(model.closures.length, 1);
});
