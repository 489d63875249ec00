import assert from "node:assert/strict";
import { test } from "node:test";
import { parseEdits } from "../demo/edited.ts";
import { Random } from "../demo/random.ts";
import * as toml from "../src/edit_toml.ts";
import type { Edit } from "../src/edits.ts";

const kSquare = [
  { x: 0, y: 0 },
  { x: 2.5, y: 0 },
  { x: 2.5, y: -1.25 },
];

test("numbers have every digit of a micrometre, and no more", () => {
  const cases: [number, string][] = [
    [0, "0"],
    [-0, "0"],
    [-1e-9, "0"],
    [10, "10"],
    [100.5, "100.5"],
    [-3.25, "-3.25"],
    [1 / 3, "0.333333"],
    [Math.PI, "3.141593"],
    [-712345.000004, "-712345.000004"],
    [1e-6, "0.000001"],
  ];
  for (const [value, text] of cases) assert.equal(toml.tomlNumber(value), text);
  for (const value of [NaN, Infinity, -Infinity])
    assert.throws(() => toml.tomlNumber(value), RangeError);
  const random = new Random(3);
  for (let i = 0; i < 1000; i++) {
    const value = random.between(-1e5, 1e5);
    const text = toml.tomlNumber(value);
    assert.ok(/^-?\d+(\.\d*[1-9])?$/.test(text), text);
    assert.ok(Math.abs(Number(text) - value) <= 5e-7 + 1e-11);
  }
});

test("nodes are whole numbers from 0", () => {
  assert.equal(toml.tomlIndex(812), "812");
  for (const value of [-1, 0.5, NaN, 2 ** 60])
    assert.throws(() => toml.tomlIndex(value), RangeError);
});

test("names are quoted; what TOML does not take as it is is escaped", () => {
  assert.equal(toml.tomlText("stairs"), '"stairs"');
  assert.equal(toml.tomlText('the "old" C:\\'), '"the \\"old\\" C:\\\\"');
  assert.equal(toml.tomlText("a\nb\t\u0000\u007f"), '"a\\u000Ab\\u0009\\u0000\\u007F"');
  assert.equal(toml.tomlText("Küche 🧱"), '"Küche 🧱"');
  assert.equal(toml.tomlText("half \ud83e of one"), '"half \ufffd of one"');
});

test("a name comes back as it went, whatever is in it", () => {
  const random = new Random(4);
  for (let i = 0; i < 500; i++) {
    const name = Array.from({ length: 1 + random.integer(12) }, () => {
      const code = random.integer(10) === 0 ? random.integer(0x10ffff) : random.integer(130);
      return code >= 0xd800 && code <= 0xdfff ? "x" : String.fromCodePoint(code);
    }).join("");
    const text = toml.polygonEdit("keep_out", kSquare, name);
    assert.equal(toml.valueIn(text, "name"), name);
    assert.equal(text.split("\n").length, 5, "no name ends its line");
  }
});

test("each edit in its words", () => {
  assert.equal(
    toml.deleteClosure(136, 750),
    '[[edit]]\nkind = "delete_closure"\nfrom_node = 136\nto_node = 750\n',
  );
  const pair = { from: 3, to: 90, guess: null, halfWindow: null, force: false };
  assert.equal(
    toml.addClosure(pair),
    '[[edit]]\nkind = "add_closure"\nfrom_node = 3\nto_node = 90\n',
  );
  const guess = { x: 0.5, y: -0.125, yaw: 0.1 };
  assert.equal(
    toml.addClosure({ ...pair, guess, halfWindow: 2, force: true }),
    '[[edit]]\nkind = "add_closure"\nfrom_node = 3\nto_node = 90\nx_m = 0.5\ny_m = -0.125\n' +
      "yaw_rad = 0.1\nhalf_window_m = 2\nforce = true\n",
  );
  const stretch = '[[edit]]\nkind = "ignore"\nfrom_node = 5\nto_node = 20\n';
  assert.equal(toml.ignoreStretch(5, 20), stretch);
  assert.equal(toml.ignoreStretch(20, 5), stretch, "whichever end is told first");
  assert.equal(
    toml.polygonEdit("crop", kSquare),
    '[[edit]]\nkind = "crop"\npolygon = [[0, 0], [2.5, 0], [2.5, -1.25]]\n',
  );
  assert.equal(
    toml.polygonEdit("speed", kSquare, "ramp", { percent: 40 }),
    '[[edit]]\nkind = "speed"\nname = "ramp"\n' +
      "polygon = [[0, 0], [2.5, 0], [2.5, -1.25]]\npercent = 40\n",
  );
  assert.match(
    toml.polygonEdit("speed", kSquare, "", { metresPerSecond: 0.3 }),
    /\]\]\nlimit_m_s = 0\.3\n$/,
  );
  assert.equal(toml.straighten(), '[[edit]]\nkind = "straighten"\n');
  assert.equal(toml.origin({ x: 1, y: 2 }, null), '[[edit]]\nkind = "origin"\nx_m = 1\ny_m = 2\n');
  assert.match(toml.origin({ x: 1, y: 2 }, 1.5), /yaw_rad = 1\.5\n$/);
});

test("what is told on the map in sight says so behind other edits, and only there", () => {
  const crop = toml.polygonEdit("crop", kSquare);
  const edits = [{ kind: "straighten" } as Edit];
  assert.equal(toml.onShownMap(crop, null), crop);
  assert.equal(toml.onShownMap(crop, { edits: [] }), crop);
  assert.equal(toml.onShownMap(crop, { edits }), `[[edit]]\nkind = "as_edited"\n\n${crop}`);
  assert.deepEqual(
    parseEdits(toml.onShownMap(crop, { edits })).map((one) => one.kind),
    ["as_edited", "crop"],
  );
});

test("a key's value is found in any of TOML's quotes, and no other key's", () => {
  assert.equal(toml.valueIn("surname = 'b'\n  name = 'a\\n'\n", "name"), "a\\n");
  assert.equal(toml.valueIn("percent = 50.0\n", "percent"), "50.0");
  assert.equal(toml.valueIn('name = "\\u00e9\\t\\U0001F9F1"', "name"), "é\t🧱");
  assert.equal(toml.valueIn('kind = "name = 5"\n', "name"), null);
  assert.equal(toml.valueIn("", "name"), null);
});
