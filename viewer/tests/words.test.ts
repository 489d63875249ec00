import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { test } from "node:test";
import { colourOf, kPalettes, rampTable } from "../src/colours.ts";
import { clock, metres, significant } from "../src/format.ts";
import { Settings } from "../src/settings.ts";
import { sortClosures } from "../src/ui/closures_panel.ts";
import { figureLabel } from "../src/words.ts";

test("times", () => {
  assert.equal(clock(0), "0:00");
  assert.equal(clock(59.96, 1), "1:00.0");
  assert.equal(clock(3725.25, 1), "1:02:05.3");
  assert.equal(clock(-65), "-1:05");
});

test("lengths and numbers", () => {
  assert.deepEqual([0.0042, 0.25, 12.345, 379.04, 12_345].map(metres), [
    "0.4 cm",
    "25 cm",
    "12.35 m",
    "379 m",
    "12.3 km",
  ]);
  assert.deepEqual(
    [0, 0.5, 12.34, 1234.5, 0.00001, NaN].map((one) => significant(one)),
    ["0", "0.5", "12.3", "1235", "1.00e-5", "–"],
  );
});

test("figures have names, known or not", () => {
  assert.equal(figureLabel("sigma_m"), "uncertainty of position [m]");
  assert.equal(figureLabel("queue_length_m"), "queue length [m]");
  assert.equal(figureLabel("loss"), "loss");
});

test("closures without a value come last, whichever way they are sorted", () => {
  const closures = [3, null, 1, 2].map((score, id) => ({ id, score }));
  const by = (descending: boolean) =>
    sortClosures(closures as never, (one) => one.score, descending).map((one) => one.score);
  assert.deepEqual(by(false), [1, 2, 3, null]);
  assert.deepEqual(by(true), [3, 2, 1, null]);
});

test("choices are remembered, and nonsense in their place is not taken", () => {
  const kept = new Map<string, string>();
  const storage = {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => void kept.set(key, value),
  };
  const first = new Settings(storage);
  first.layers.scan = false;
  first.opacity.quality = 0.25;
  first.theme = "light";
  first.save();
  const second = new Settings(storage);
  assert.equal(second.layers.scan, false);
  assert.equal(second.opacity.quality, 0.25);
  assert.equal(second.theme, "light");
  for (const text of [
    "",
    "null",
    "[]",
    '{"layers":5,"opacity":{"map":"x"},"theme":"pink","plots":{}}',
  ]) {
    kept.set("loopstone.view", text);
    const other = new Settings(storage);
    assert.equal(other.theme, "system");
    assert.equal(other.opacity.map, 1);
    assert.equal(other.plots, null);
  }
  const forbidden = () => {
    throw new Error("forbidden");
  };
  new Settings({ getItem: forbidden, setItem: forbidden }).save();
});

test("a ramp begins and ends with its colours", () => {
  const table = rampTable(["#000000", "#ff0000"], 11);
  assert.deepEqual([...table.subarray(0, 3)], [0, 0, 0]);
  assert.deepEqual([...table.subarray(30)], [255, 0, 0]);
  assert.equal(table[15], 128);
});

function luminance(hex: string): number {
  const [r, g, b] = colourOf(hex).map((c) =>
    c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4,
  );
  return 0.2126 * (r ?? 0) + 0.7152 * (g ?? 0) + 0.0722 * (b ?? 0);
}

/** WCAG 2.1. */
function contrast(a: string, b: string): number {
  const [light = 0, dark = 0] = [luminance(a), luminance(b)].sort((x, y) => y - x);
  return (light + 0.05) / (dark + 0.05);
}

test("text stands out by 4.5 to 1 on every ground, lines of closures by 3 to 1", async () => {
  const css = await readFile("src/style.css", "utf8");
  for (const theme of ["dark", "light"] as const) {
    const block = new RegExp(`\\[data-theme="${theme}"\\]\\s*{([^}]*)}`).exec(css)?.[1] ?? "";
    const colours = new Map(
      [...block.matchAll(/--([a-z-]+):\s*(#[0-9a-f]{6})/g)].map(([, name, hex]) => [name, hex]),
    );
    const of = (name: string) => {
      const hex = colours.get(name);
      assert.ok(hex, `${theme} has no --${name}`);
      return hex;
    };
    for (const ink of ["ink", "soft", "accent", "good", "doubt", "bad"]) {
      for (const ground of ["panel", "raised", "ground"]) {
        const ratio = contrast(of(ink), of(ground));
        assert.ok(ratio >= 4.5, `${theme}: ${ink} on ${ground} has ${ratio.toFixed(2)}`);
      }
    }
    assert.ok(contrast(of("on-accent"), of("accent")) >= 4.5);
    assert.ok(contrast(of("ink"), of("press")) >= 4.5);
    const free = `#${kPalettes[theme].free
      .map((c) =>
        Math.round(255 * c)
          .toString(16)
          .padStart(2, "0"),
      )
      .join("")}`;
    const lines = { ...kPalettes[theme].closures, ...kPalettes[theme].edits };
    for (const [state, hex] of Object.entries(lines)) {
      const ratio = contrast(hex, free);
      assert.ok(ratio >= 3, `${theme}: ${state} has ${ratio.toFixed(2)} on free floor`);
    }
  }
});
