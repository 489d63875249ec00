import assert from "node:assert/strict";
import { test } from "node:test";
import { EditClient, type EditSurroundings } from "../src/edit_client.ts";
import { Model } from "../src/model.ts";

type Answer = { status: number; body: unknown } | Error;

function begin() {
  const model = new Model();
  const asked: { url: string; body: unknown }[] = [];
  const answers: Answer[] = [];
  const timers = new Map<number, { task: () => void; wait: number }>();
  let next = 1;
  const around: EditSurroundings = {
    fetch: (url, init) => {
      asked.push({ url, body: init === undefined ? null : JSON.parse(init.body) });
      const answer = answers.shift() ?? new Error("nobody there");
      if (answer instanceof Error) return Promise.reject(answer);
      const { status, body } = answer;
      const text = typeof body === "string" ? body : JSON.stringify(body);
      return Promise.resolve({ ok: status < 400, status, text: () => Promise.resolve(text) });
    },
    setTimeout: (task, wait) => {
      timers.set(next, { task, wait });
      return next++;
    },
    clearTimeout: (timer) => timers.delete(timer),
  };
  const client = new EditClient(
    model,
    (path) => `http://h/${path}?token=t`,
    around,
    () => undefined,
  );
  model.connection = { state: "open" };
  const allow = (canEdit: boolean) => {
    model.about = { version: "", mode: "replay", name: "", canSeek: true, canEdit };
    model.changed("about");
  };
  const settle = () => new Promise((done) => setImmediate(done));
  const run = async () => {
    const due = [...timers.entries()][0];
    assert.ok(due, "a timer runs");
    timers.delete(due[0]);
    due[1].task();
    await settle();
    return due[1].wait;
  };
  return { model, client, asked, answers, timers, allow, settle, run };
}

function state(kinds: string[], revision: number, drawn = revision, applied = true) {
  const edits = kinds.map((kind, i) => ({
    kind,
    toml: "",
    applied: applied || i < kinds.length - 1,
    told: "t",
  }));
  return { status: 200, body: { edits, revision, drawn, saved: -1, file: "f", command: "c" } };
}

test("nothing is asked where nobody may edit", async () => {
  const { allow, asked, settle, model, timers } = begin();
  allow(false);
  model.changed("closures");
  await settle();
  assert.equal(asked.length + timers.size, 0);
});

test("the list is asked for, and again until the map is drawn", async () => {
  const { allow, asked, answers, settle, run, model, timers } = begin();
  answers.push(state(["crop"], 3, 2), state(["crop"], 3, 3));
  allow(true);
  await settle();
  assert.equal(asked[0]?.url, "http://h/api/edits?token=t");
  assert.equal(model.edits?.drawn, 2);
  assert.equal(await run(), 500);
  assert.equal(model.edits?.drawn, 3);
  assert.equal(timers.size, 0, "and then no more");
});

test("news of the run ask once, however many come", async () => {
  const { allow, answers, settle, model, timers, run } = begin();
  answers.push(state([], 0), state([], 0));
  allow(true);
  await settle();
  for (const part of ["closures", "trajectory", "verdict"] as const) model.changed(part);
  assert.equal(timers.size, 1);
  await run();
  assert.equal(timers.size, 0);
});

test("edits are sent, told on the map in sight where they are; one at a time", async () => {
  const { allow, answers, asked, settle, client } = begin();
  answers.push(state(["crop"], 1), state(["crop", "erase"], 2));
  allow(true);
  await settle();
  const first = client.add("E", true, "Doing …");
  assert.equal(client.busy, "Doing …");
  const second = await client.undo();
  assert.ok(!second.done && second.why.includes("try again"));
  assert.ok((await first).done);
  assert.equal(client.busy, "");
  assert.deepEqual(asked[1]?.body, { toml: '[[edit]]\nkind = "as_edited"\n\nE' });
});

test("what was refused is taken off before the next edit, and before saving", async () => {
  const { allow, answers, asked, settle, client } = begin();
  answers.push(state(["crop", "add_closure"], 2, 2, false), state(["crop"], 3));
  answers.push(state(["crop", "erase"], 4));
  allow(true);
  await settle();
  assert.ok((await client.add("E", false, "")).done);
  const paths = asked.map(({ url }) => new URL(url).pathname);
  assert.deepEqual(paths, ["/api/edits", "/api/edits/undo", "/api/edits"]);
  assert.deepEqual(asked[2]?.body, { toml: "E" });
});

test("undo takes markers along; of an empty list nothing", async () => {
  const { allow, answers, asked, settle, client, model } = begin();
  answers.push(state(["crop", "as_edited"], 2), state(["crop"], 3), state([], 4));
  allow(true);
  await settle();
  assert.ok((await client.undo()).done);
  assert.equal(model.edits?.edits.length, 0);
  assert.ok((await client.undo()).done);
  assert.equal(asked.length, 3);
});

test("refusals, silence and damage are told; what was known stays, and is asked for again", async () => {
  const { allow, answers, settle, client, model, run } = begin();
  answers.push(state(["crop"], 1));
  allow(true);
  await settle();
  const cases: [Answer, RegExp][] = [
    [
      { status: 409, body: { error: "another edit is being done" } },
      /^another edit is being done$/,
    ],
    [{ status: 413, body: "too much" }, /answered with 413/],
    [{ status: 200, body: "{" }, /could not be read/],
    [{ status: 200, body: { edits: [7], revision: 1, drawn: 1 } }, /could not be read/],
    [new Error("ECONNRESET"), /does not answer.*may have been done/],
  ];
  for (const [answer, words] of cases) {
    answers.push(answer);
    const outcome = await client.add("E", false, "");
    assert.ok(!outcome.done);
    assert.match(outcome.why, words);
    assert.equal(model.edits?.edits.length, 1);
    answers.push(state(["crop"], 1));
    assert.equal(await run(), 2000);
  }
});

test("an answer from before a change is not taken for what came after", async () => {
  const { allow, answers, settle, client, model } = begin();
  answers.push(state([], 0));
  allow(true);
  await settle();
  answers.push(state([], 0), state(["crop"], 1));
  const old = client.ask();
  const added = client.add("E", false, "");
  await Promise.all([old, added]);
  assert.equal(model.edits?.edits.length, 1);
});

test("another run: the list is forgotten, and asked for when it is known that one may edit", async () => {
  const { allow, answers, settle, model } = begin();
  answers.push(state(["crop"], 1), state([], 0));
  allow(true);
  await settle();
  const count = () => model.edits?.edits.length ?? null;
  assert.equal(count(), 1);
  model.reset();
  assert.equal(count(), null);
  allow(true);
  await settle();
  assert.equal(count(), 0);
});

test("a list that cannot be read is a note, and asked for again", async () => {
  const { allow, answers, settle, model, run } = begin();
  answers.push({ status: 200, body: "[]" }, state([], 0));
  allow(true);
  await settle();
  assert.match(model.notes[0] ?? "", /list of edits.*could not be read/);
  assert.equal(await run(), 2000);
  assert.notEqual(model.edits, null);
});
