import assert from "node:assert/strict";
import { test } from "node:test";
import { Random } from "../demo/random.ts";
import { nodeAt, nearestVisit, visitsNear } from "../src/edit/visits.ts";
import { areaOf, faultOf, middleOf } from "../src/edit/polygon.ts";
import { numberIn } from "../src/edit/polygon_tool.ts";
import { readEditState, readRefusal } from "../src/edits.ts";
import { parseClock } from "../src/format.ts";
import { readPicture } from "../src/json_messages.ts";
import { Track } from "../src/track.ts";
import { editWords, figureWords, shiftWords, zoneName } from "../src/words.ts";

const kEdit = {
  kind: "keep_out",
  toml: '[[edit]]\nkind = "keep_out"\nname = "stairs"\n',
  applied: true,
  told: "6.0 m2 are not to be entered",
  seconds: 0.02,
  verdict_before: "good",
  verdict: "doubtful",
  shift: { mean_m: 0.01, largest_m: 0.4, largest_rad: 0.02 },
  polygon: [0, 0, 3, 0, 3, 2],
  closure: null,
};
const kState = {
  edits: [kEdit, { ...kEdit, kind: "add_closure", applied: false, closure: { score: 0.4 } }],
  revision: 7,
  drawn: 6,
  saved: -1,
  file: "out.edits.toml",
  command: "loopstone edit out",
  verdict: "doubtful",
  sentence: "s",
  shift: null,
};

test("a list of edits", () => {
  const state = readEditState(JSON.stringify(kState));
  assert.ok(state);
  assert.deepEqual([state.revision, state.drawn, state.saved], [7, 6, -1]);
  const [zone, closure] = state.edits;
  assert.deepEqual(zone?.polygon, [0, 0, 3, 0, 3, 2]);
  assert.deepEqual(zone?.shift, { mean: 0.01, largest: 0.4, turned: 0.02 });
  assert.equal(zone?.verdictBefore, "good");
  assert.equal(closure?.applied, false);
  assert.equal(closure?.closure?.score, 0.4);
  assert.equal(closure?.closure?.chi2, null);
});

test("what is no list of edits is none", () => {
  for (const text of ["", "null", "[]", "{", '"a"', "{}", '{"edits":{},"revision":1,"drawn":1}'])
    assert.equal(readEditState(text), null, text);
  assert.equal(readEditState(JSON.stringify({ ...kState, revision: "7" })), null);
  assert.equal(readEditState(JSON.stringify({ ...kState, drawn: undefined })), null);
  assert.equal(readEditState(JSON.stringify({ ...kState, edits: [kEdit, 5] })), null, "a hole");
});

test("of a damaged edit what is missing is not made up", () => {
  const odd = {
    kind: 5,
    toml: null,
    polygon: [0, 0, "x", 1, 2, 3],
    shift: [],
    verdict: "splendid",
  };
  const state = readEditState(JSON.stringify({ ...kState, edits: [odd, { polygon: [1, 2, 3] }] }));
  for (const edit of state?.edits ?? []) {
    assert.deepEqual([edit.kind, edit.toml, edit.applied], ["", "", false]);
    assert.deepEqual([edit.polygon, edit.shift, edit.verdict], [[], null, ""]);
  }
  assert.equal(state?.edits.length, 2);
});

test("spoiled text never throws", () => {
  const random = new Random(11);
  const good = JSON.stringify(kState);
  let read = 0;
  for (let i = 0; i < 3000; i++) {
    const at = random.integer(good.length);
    const letter = '{}[]",:0e-nt'[random.integer(12)] ?? "";
    const text = good.slice(0, at) + letter + good.slice(at + random.integer(4));
    const state = readEditState(i % 3 === 0 ? good.slice(0, at) : text);
    if (state !== null) read++;
    for (const edit of state?.edits ?? []) {
      assert.equal(typeof editWords(edit) + typeof shiftWords(edit.shift), "stringstring");
      zoneName("speed", edit.toml);
    }
  }
  assert.ok(read > 100, `${read} could still be read`);
});

test("why the server refuses, in its own words", () => {
  assert.equal(readRefusal('{"error":"busy"}', 409), "busy");
  assert.equal(readRefusal("<html>", 502), "The server answered with 502.");
  assert.equal(readRefusal('{"error":5}', 400), "The server answered with 400.");
});

test("edits in words", () => {
  const toml = '[[edit]]\nkind = "speed"\nname = "at the \\"door\\""\nlimit_m_s = 0.3\n';
  assert.equal(editWords({ kind: "speed", toml }), 'Speed zone “at the "door"”');
  assert.equal(zoneName("speed", toml), 'at the "door": 0.3 m/s');
  assert.equal(zoneName("speed", "percent = 50\n"), "slow: 50 %");
  assert.equal(zoneName("crop", ""), "crop");
  assert.equal(editWords({ kind: "shear_all", toml: "" }), "shear all");
  assert.equal(shiftWords({ mean: 0, largest: 0, turned: 0 }), "Nothing moved.");
  assert.equal(
    shiftWords({ mean: 0.01, largest: 0.41, turned: Math.PI / 180 }),
    "Moved by up to 41 cm, 1.0 cm on average, turned by up to 1°.",
  );
  const figures = { score: 0.82, overlap: 0.7, agreement: null, secondScore: null, chi2: 1.5 };
  assert.equal(figureWords(figures), "score 0.82, overlap 70 %, χ² 1.5");
});

test("polygons: area, middle, what is wrong with them", () => {
  const square = [
    [1000, 2000],
    [1002, 2000],
    [1002, 2002],
    [1000, 2002],
  ].map(([x = 0, y = 0]) => ({ x, y }));
  assert.ok(Math.abs(areaOf(square) - 4) < 1e-6);
  const middle = middleOf(square);
  assert.ok(Math.hypot(middle.x - 1001, middle.y - 2001) < 1e-9);
  assert.equal(faultOf(square), null);
  assert.equal(faultOf([...square].reverse()), null, "either way around");
  const [a, b, c, d] = square;
  assert.ok(a && b && c && d);
  assert.match(faultOf([a, c, b, d]) ?? "", /cross/);
  assert.match(faultOf([a, b]) ?? "", /three/);
  assert.match(faultOf([a, b, { x: 1001, y: 2000 }]) ?? "", /no ground/);
  assert.match(faultOf(Array.from({ length: 1001 }, () => a)) ?? "", /at most/);
});

function trackOf(points: [number, number][]): Track {
  const n = points.length;
  const track = new Track();
  track.replace({
    first: 0,
    count: n,
    t: Float64Array.from(points, (_, i) => 100 + i),
    poses: Float32Array.from(points.flatMap(([x, y]) => [x, y, 0])),
    sigma: new Float32Array(n),
    submaps: new Uint32Array(n),
    drives: new Uint32Array(n),
  });
  return track;
}

test("visits of a place: each by its nearest node, the other one first", () => {
  const there = Array.from({ length: 41 }, (_, i): [number, number] => [i - 20, 0]);
  const back = Array.from({ length: 41 }, (_, i): [number, number] => [20 - i, 0.5]);
  const track = trackOf([...there, ...back]);
  const visits = visitsNear(track, { x: 0.2, y: 0.1 }, 2);
  assert.deepEqual(
    visits.map((one) => one.node),
    [20, 61],
  );
  assert.equal(nearestVisit(visits, null)?.node, 20);
  assert.equal(nearestVisit(visits, 20)?.node, 61, "not the visit that is chosen already");
  assert.equal(nearestVisit(visits.slice(0, 1), 20)?.node, 20, "there being no other");
  assert.deepEqual(visitsNear(track, { x: 0, y: 50 }, 2), []);
  assert.equal(nearestVisit([], null), null);
  assert.equal(nodeAt(track, 130.4), 30);
  assert.equal(nodeAt(track, -5), 0);
  assert.equal(nodeAt(new Track(), 5), null);
});

test("what a reader writes: times and numbers, or nothing", () => {
  assert.deepEqual(
    ["2:13.4", "1:02:13", "133,4", " 0:05 ", ".5"].map(parseClock),
    [133.4, 3733, 133.4, 5, 0.5],
  );
  for (const text of ["", "a", "1:2:3:4", "-5", "1:", ":5", "1.5:2", "Infinity", "1e3"])
    assert.equal(parseClock(text), null, text);
  assert.deepEqual(["1.5", "-2,25", "+3", " 7 ", "5."].map(numberIn), [1.5, -2.25, 3, 7, 5]);
  for (const text of ["", "x", "1e5", "0x10", "1 2", "NaN", "--1", "."])
    assert.ok(Number.isNaN(numberIn(text)), text);
});

test("a picture that there is no more is none, and no damage", () => {
  assert.deepEqual(readPicture('{"x":0,"y":0,"resolution":1,"png":""}'), { picture: null });
  assert.deepEqual(readPicture('{"x":1,"y":2,"resolution":0.1,"png":"aa"}')?.picture?.x, 1);
  for (const text of ["{}", "[]", '{"x":0,"y":0,"resolution":0,"png":"aa"}', '{"png":5}'])
    assert.equal(readPicture(text), null, text);
});
