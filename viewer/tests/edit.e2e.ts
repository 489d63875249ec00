/** Editing in a browser: each tool from its button to the map, by pointer and by keyboard. */
import assert from "node:assert/strict";
import type { Page } from "playwright-core";
import { BadRequest } from "../demo/edited.ts";
import { DemoServer } from "../demo/server.ts";
import { kPalettes } from "../src/colours.ts";
import { compose, inverse } from "../src/geometry.ts";
import type { PageState } from "../src/state.ts";
import { nodeOf, screenOf, stateOf } from "./support/browser.ts";
import { countOf, differingShare } from "./support/images.ts";
import { run, scene as anyScene, type Scene, type SceneOptions, shown } from "./support/scene.ts";

/** A run that can be edited, and is drawn soon. */
function scene(name: string, options: SceneOptions, act: (scene: Scene) => Promise<void>): void {
  const server = { edit: true, drawDelay: 150, ...options.server };
  anyScene(name, { ...options, server }, act);
}

const editable = (state: PageState) => shown(state) && state.edits !== null;
const kinds = (state: PageState) =>
  (state.edits?.edits ?? []).filter((one) => one.kind !== "as_edited").map((one) => one.kind);
const drawn = (state: PageState) => state.edits?.drawn === state.edits?.revision;

/** What was done is shown with the next picture. */
async function nextPicture(page: Page): Promise<void> {
  await page.evaluate(
    () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))),
  );
}

async function clickAt(page: Page, x: number, y: number): Promise<void> {
  const at = await screenOf(page, x, y);
  await page.mouse.click(at.x, at.y);
  await nextPicture(page);
}

async function clickNode(page: Page, i: number): Promise<void> {
  const node = await nodeOf(page, i);
  assert.ok(node);
  await clickAt(page, node.x, node.y);
}

async function dragFrom(page: Page, from: [number, number], by: [number, number]): Promise<void> {
  const at = await screenOf(page, ...from);
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  await page.mouse.move(at.x + by[0], at.y + by[1], { steps: 5 });
  await page.mouse.up();
  await nextPicture(page);
}

/** Waits until an element says it. */
async function says(page: Page, selector: string, words: RegExp): Promise<void> {
  const begin = Date.now();
  let text = "";
  while (Date.now() - begin < 8000) {
    text = await page.locator(selector).first().innerText();
    if (words.test(text)) return;
    await page.waitForTimeout(30);
  }
  assert.match(text, words, selector);
}

const kCorners: [number, number][] = [
  [15, 2],
  [19, 2],
  [19, 6],
  [15, 6],
];

async function drawPolygon(page: Page, corners = kCorners): Promise<void> {
  for (const [x, y] of corners) await clickAt(page, x, y);
}

anyScene(
  "where nothing can be edited, nothing of it is seen",
  {},
  async ({ page, until, server }) => {
    await until(shown, "shown");
    assert.ok(await page.locator("#tab-edit").isHidden());
    const before = (await stateOf(page)).tab;
    await page.keyboard.press("5");
    assert.equal((await stateOf(page)).tab, before);
    await page.click("#tab-layers");
    assert.ok(await page.locator("#layer-edits").isHidden());
    await page.keyboard.press("n");
    await until((one) => one.selected !== null, "a closure");
    assert.ok(await page.locator("#closure-delete").isHidden());
    await page.keyboard.press("Delete");
    await page.keyboard.press("Control+z");
    await page.keyboard.press("?");
    assert.ok(!(await page.locator("dialog").innerText()).includes("Editing"));
    await page.keyboard.press("Escape");
    await page.click("#tab-plots");
    await page.keyboard.press("ArrowRight");
    assert.equal((await stateOf(page)).tab, "overview", "arrows leave it out");
    assert.ok(server.requests.every((url) => !url.startsWith("/api/edits")));
  },
);

scene("a closure is deleted by its button, by key, and comes back", {}, async (tools) => {
  const { page, until, server } = tools;
  await until(editable, "shown");
  await page.keyboard.press("2");
  const closure = run.closures.find((one) => one.state === "standing");
  assert.ok(closure);
  await page.locator(`#closure-${closure.id}`).click();
  const was = await nodeOf(page, closure.to);
  await page.click("#closure-delete");
  const state = await until((one) => kinds(one).length === 1 && drawn(one), "deleted");
  assert.equal(state.closures, run.closures.length - 1);
  assert.equal(state.verdict, "bad");
  const now = await nodeOf(page, closure.to);
  assert.ok(Math.abs((now?.y ?? 0) - (was?.y ?? 0)) > 0.05, "the path moved at once");
  assert.match(server.edits?.asked[0] ?? "", new RegExp(`from_node = ${closure.from}\nto_node`));
  await page.keyboard.press("5");
  const item = page.locator(".edits > li").first();
  assert.match(
    await item.innerText(),
    /Closure deleted[^]*is out[^]*Moved by up to[^]*Doubtful[^]*Bad/,
  );
  await page.locator("#live p", { hasText: /^Done: closure \d+ is out/ }).waitFor();
  await page.locator("#live p", { hasText: "drawn with the last edit" }).waitFor();
  await page.keyboard.press("2");
  await page.keyboard.press("n");
  await until((one) => one.selected !== null, "another");
  await page.keyboard.press("Delete");
  await until((one) => kinds(one).length === 2, "deleted by key");
  await page.keyboard.press("Control+z");
  await until((one) => kinds(one).length === 1, "one is undone");
  await page.keyboard.press("5");
  await page.click("#edit-undo");
  const last = await until((one) => kinds(one).length === 0 && drawn(one), "all are undone");
  assert.equal(last.closures, run.closures.length);
  assert.equal(last.verdict, "doubtful");
  assert.equal(await page.locator("#edit-undo").getAttribute("aria-disabled"), "true");
  await page.keyboard.press("Control+z");
  await page.locator("#edit-message", { hasText: "nothing to undo" }).waitFor();
});

scene("only a closure that stands can be deleted", {}, async ({ page, until, state }) => {
  await until(editable, "shown");
  await page.keyboard.press("2");
  await page.locator("[data-state=rejected] input").click();
  for (const word of ["standing", "waiting", "revoked"])
    await page.locator(`[data-state=${word}] input`).click();
  await page.keyboard.press("n");
  await until((one) => one.selected !== null, "a rejected one");
  assert.ok(await page.locator("#closure-delete").isHidden());
  await page.keyboard.press("Delete");
  assert.match((await state()).edit.message.text, /does not stand/);
  await says(page, "#edit-words", /does not stand/);
});

scene("a zone by clicks: closed, corrected, named, drawn on the map", {}, async (tools) => {
  const { page, until, picture, settle, server } = tools;
  await until(editable, "shown");
  await page.keyboard.press("5");
  const before = await picture();
  await page.click("#edit-keep_out");
  await says(page, "#edit-words", /first corner/);
  await page.locator("#edit-send").click();
  await says(page, "#edit-message", /close it/);
  await drawPolygon(page);
  await clickAt(page, 22, 4);
  await page.keyboard.press("Backspace");
  await says(page, ".edit-form", /4 corners so far/);
  await clickAt(page, ...(kCorners[0] as [number, number]));
  await says(page, ".edit-form", /4 corners, 16\.0 m²/);
  await dragFrom(page, [19, 6], [30, 0]);
  await page.fill("#edit-name", 'the "old" stairs');
  await page.keyboard.press("2");
  assert.equal((await stateOf(page)).tab, "edit", "a name may have a 2");
  await page.fill("#edit-name", 'the "old" stairs');
  await page.click("#edit-send");
  const state = await until((one) => kinds(one).length === 1 && drawn(one), "added");
  await says(page, "#edit-words", /^Done: \d+\.\d m2 are not to be entered/);
  await page.locator("#edit-words").getByRole("button", { name: "Close" }).click();
  assert.equal(state.edit.tool, null);
  const polygon = state.edits?.edits[0]?.polygon ?? [];
  assert.equal(polygon.length, 8);
  assert.ok(Math.abs((polygon[0] ?? 0) - 15) < 0.1 && (polygon[4] ?? 0) > 19.5, String(polygon));
  assert.ok(server.edits?.asked[0]?.includes('name = "the \\"old\\" stairs"'));
  await says(page, ".edits", /Keep-out zone “the "old" stairs”/);
  await page.mouse.move(5, 5);
  await settle();
  const zone = kPalettes.dark.edits.keep_out;
  const colour = [1, 3, 5].map((i) => Number.parseInt(zone.slice(i, i + 2), 16));
  const after = await picture();
  assert.ok(countOf(after, colour as [number, number, number]) > 100, "its edge");
  await page.click("#tab-layers");
  await page.click("#layer-edits");
  await settle();
  assert.ok(differingShare(before, await picture()) < 0.002, "without the layer all is as before");
});

scene("a double click and Enter close; Esc ends", {}, async ({ page, until, state, settle }) => {
  await until(editable, "shown");
  await page.keyboard.press("5");
  await page.click("#edit-erase");
  await drawPolygon(page, kCorners.slice(0, 3));
  const at = await screenOf(page, 15, 6);
  await page.mouse.dblclick(at.x, at.y);
  assert.equal((await state()).edit.problem, null);
  assert.equal((await state()).edit.toml.match(/\], \[/g)?.length, 3, "four corners");
  await page.keyboard.press("Escape");
  assert.equal((await state()).edit.tool, null);
  await page.locator("#edit-words").waitFor({ state: "hidden" });
  await page.click("#edit-erase");
  await drawPolygon(page);
  await page.keyboard.press("Enter");
  assert.equal((await state()).edit.problem, null);
  await dragFrom(page, [15, 6], [120, 0]);
  await says(page, "#edit-words", /^Sides of the polygon cross each other/);
  await page.keyboard.press("Control+z");
  assert.match((await state()).edit.problem ?? "", /close it/, "Ctrl+Z opens it again");
  await page.click("#edit-cancel");
  assert.equal((await state()).edit.tool, null);
  await settle();
  assert.equal(await page.evaluate(() => document.activeElement?.id), "edit-erase");
});

scene("a box by dragging, with Shift or the button; crop and erase", {}, async (tools) => {
  const { page, until, state, picture, settle } = tools;
  await until(editable, "shown");
  const before = await picture();
  await page.keyboard.press("5");
  await page.click("#edit-crop");
  await page.keyboard.down("Shift");
  await dragFrom(page, [7, 23], [250, 280]);
  await page.keyboard.up("Shift");
  assert.equal((await state()).edit.problem, null);
  await page.click("#edit-send");
  await until((one) => kinds(one).length === 1 && drawn(one), "cropped");
  await settle();
  assert.ok(differingShare(before, await picture()) > 0.05);
  await page.click("#edit-erase");
  await page.click("#edit-box");
  await dragFrom(page, [9, 5], [60, 40]);
  await page.click("#edit-send");
  const now = await until((one) => kinds(one).length === 2 && drawn(one), "erased");
  assert.deepEqual(
    now.edits?.edits.map((one) => one.kind),
    ["crop", "as_edited", "erase"],
  );
});

scene("speed zones: in percent or m/s; what is refused says why", {}, async (tools) => {
  const { page, until, server } = tools;
  await until(editable, "shown");
  await page.keyboard.press("5");
  await page.click("#edit-speed");
  await drawPolygon(page);
  await page.click("#edit-close");
  await page.fill("#edit-percent", "140");
  await page.click("#edit-send");
  await says(page, "#edit-message", /1 to 100 percent/);
  await page.fill("#edit-percent", "40");
  await page.fill("#edit-name", "ramp");
  await page.click("#edit-send");
  await until((one) => kinds(one).length === 1 && drawn(one), "in percent");
  await page.click("#edit-speed");
  await drawPolygon(
    page,
    kCorners.map(([x, y]) => [x + 7, y]),
  );
  await page.click("#edit-close");
  await page.fill("#edit-limit", "0,3");
  assert.equal(await page.inputValue("#edit-percent"), "");
  await page.click("#edit-send");
  const state = await until((one) => kinds(one).length === 2, "refused");
  assert.equal(state.edits?.edits.at(-1)?.applied, false);
  assert.equal(state.edit.tool, "speed", "it stays in hand");
  await says(page, "#edit-message", /^Refused: speeds of one map/);
  await says(page, "#edit-words", /^Refused: speeds of one map/);
  await says(page, ".edits .refused", /refused[^]*all told in percent/);
  await until(drawn, "drawn");
  await page.fill("#edit-percent", "25");
  await page.click("#edit-send");
  const last = await until((one) => one.edit.tool === null && drawn(one), "in percent, too");
  assert.deepEqual(kinds(last), ["speed", "speed"], "what was refused has left the list");
  assert.match(server.edits?.asked.at(-1) ?? "", /as_edited[^]*percent = 25\n/);
});

scene("a closure is added: two scans, dragged, turned, sent", {}, async (tools) => {
  const { page, until, state, server } = tools;
  await until(editable, "shown");
  await page.keyboard.press("5");
  await page.click("#edit-add_closure");
  await clickAt(page, 3, 22.5);
  await says(page, "#edit-words", /No path there/);
  await clickNode(page, 40);
  await says(page, "#edit-words", /second place/);
  await clickNode(page, 800);
  await until((one) => one.edit.problem === null, "both chosen");
  await page.waitForTimeout(300);
  const parse = (text: string) =>
    Object.fromEntries(
      [...text.matchAll(/^(\w+) = (-?[\d.]+)$/gm)].map(([, k, v]) => [k, Number(v)]),
    );
  const first = parse((await state()).edit.toml) as Record<string, number>;
  const [from, to] = [first["from_node"] ?? 0, first["to_node"] ?? 0];
  const truth = compose(
    inverse(run.nodes[from]?.pose ?? { x: 0, y: 0, yaw: 0 }),
    run.nodes[to]?.pose ?? { x: 0, y: 0, yaw: 0 },
  );
  assert.ok(Math.hypot((first["x_m"] ?? 9) - truth.x, (first["y_m"] ?? 9) - truth.y) < 1e-3);
  const b = await nodeOf(page, to);
  assert.ok(b);
  await dragFrom(page, [b.x, b.y], [40, 0]);
  const { scale } = (await state()).camera;
  const moved = parse((await state()).edit.toml);
  const by = Math.hypot(
    (moved["x_m"] ?? 0) - (first["x_m"] ?? 0),
    (moved["y_m"] ?? 0) - (first["y_m"] ?? 0),
  );
  assert.ok(Math.abs(by - 40 / scale) < 0.02, `moved by ${by}, not ${40 / scale}`);
  await page.keyboard.down("Shift");
  await dragFrom(page, [b.x + 3, b.y], [0, -60]);
  await page.keyboard.up("Shift");
  const turned = parse((await state()).edit.toml);
  assert.ok((turned["yaw_rad"] ?? 0) - (first["yaw_rad"] ?? 0) > 0.1, "turned, counter-clockwise");
  assert.ok(Math.abs((turned["x_m"] ?? 0) - (moved["x_m"] ?? 0)) < 1e-3, "in its place");
  const second = compose(run.nodes[from]?.pose ?? { x: 0, y: 0, yaw: 0 }, {
    x: turned["x_m"] ?? 0,
    y: turned["y_m"] ?? 0,
    yaw: turned["yaw_rad"] ?? 0,
  });
  const tip = [
    second.x + (48 / scale) * Math.cos(second.yaw),
    second.y + (48 / scale) * Math.sin(second.yaw),
  ] as [number, number];
  const aside = [-30 * Math.sin(second.yaw), -30 * Math.cos(second.yaw)] as [number, number];
  await dragFrom(page, tip, aside);
  const byArrow = parse((await state()).edit.toml);
  const angle = (byArrow["yaw_rad"] ?? 0) - (turned["yaw_rad"] ?? 0);
  assert.ok(Math.abs(angle - Math.atan2(30, 48)) < 0.03, `its arrow turns it, by ${angle}`);
  await page.keyboard.press("Control+z");
  assert.match((await state()).edit.toml, /y_m/);
  await page.locator("#edit-yaw").fill("20");
  Object.assign(turned, parse((await state()).edit.toml));
  await page.locator("#overlay").focus();
  await page.keyboard.press("ArrowUp");
  await page.keyboard.press("Shift+ArrowUp");
  await page.keyboard.press("]");
  const keyed = parse((await state()).edit.toml);
  const step = Math.hypot(
    (keyed["x_m"] ?? 0) - (turned["x_m"] ?? 0),
    (keyed["y_m"] ?? 0) - (turned["y_m"] ?? 0),
  );
  assert.ok(Math.abs(step - 0.11) < 1e-3, String(step));
  assert.ok(Math.abs((keyed["yaw_rad"] ?? 0) - (turned["yaw_rad"] ?? 0) + Math.PI / 36) < 1e-4);
  await page.fill("#edit-x", "7");
  await page.click("#edit-send");
  await until((one) => kinds(one).length === 1, "refused");
  await says(page, "#edit-result", /score 0\.\d+, overlap 34 %, agreement/);
  await says(page, ".edits .refused", /no pose within/);
  assert.equal((await state()).closures, run.closures.length);
  await page.click("#edit-reset");
  await page.click("#edit-send");
  const done = await until((one) => one.edit.tool === null && drawn(one), "added");
  assert.deepEqual(kinds(done), ["add_closure"]);
  assert.equal(done.closures, run.closures.length + 1);
  await says(page, ".edits", /score 0\.82, overlap 71 %, agreement 96 %/);
  assert.ok(server.requests.some((url) => url.startsWith(`/api/nodes/${from}/scan?token=`)));
});

scene("a closure by keyboard alone; without a guess; by force", {}, async (tools) => {
  const { page, until, state, server } = tools;
  await until(editable, "shown");
  await page.keyboard.press("5");
  await page.locator("#edit-add_closure").focus();
  await page.keyboard.press("Enter");
  await page.keyboard.press("Tab");
  assert.equal(await page.evaluate(() => document.activeElement?.id), "place-0-time");
  await page.keyboard.type("0:45");
  await page.keyboard.press("Enter");
  await page.locator("#place-1-time").focus();
  await page.keyboard.type("later");
  await page.keyboard.press("Enter");
  await says(page, "#edit-message", /such as 2:13/);
  await page.fill("#place-1-time", "5:10");
  await page.keyboard.press("Tab");
  await until((one) => one.edit.problem === null, "both");
  await page.locator("#place-1-node").focus();
  const before = (await state()).edit.toml;
  await page.keyboard.press("ArrowRight");
  assert.notEqual((await state()).edit.toml, before, "a node on");
  await page.locator("#edit-without").check();
  assert.ok(!(await state()).edit.toml.includes("x_m"));
  await page.locator("#edit-x:disabled").waitFor();
  await page.locator("#edit-without").uncheck();
  await page.locator("#edit-force-words").waitFor({ state: "hidden" });
  await page.locator("#edit-force").check();
  await says(page, "#edit-force-words", /never revoked/);
  await page.fill("#edit-half", "3.5");
  await page.fill("#edit-y", "-9");
  await page.locator("#edit-send").focus();
  await page.keyboard.press("Enter");
  const done = await until((one) => kinds(one).length === 1 && drawn(one), "forced");
  assert.equal(done.edits?.edits[0]?.applied, true);
  assert.match(server.edits?.asked[0] ?? "", /y_m = -9\n[^]*half_window_m = 3.5\nforce = true\n/);
  assert.equal(done.verdict, "bad");
  assert.equal(await page.evaluate(() => document.activeElement?.id), "edit-add_closure");
});

scene("scans that are not there: the robots alone", { expected: /404/ }, async (tools) => {
  const { page, until } = tools;
  await page.route("**/api/nodes/**", (route) => route.fulfill({ status: 404, body: "{}" }));
  await until(editable, "shown");
  await page.keyboard.press("5");
  await page.click("#edit-add_closure");
  await page.fill("#place-0-time", "0:45");
  await page.fill("#place-1-time", "5:10");
  await page.keyboard.press("Enter");
  await page.locator("#edit-scans", { hasText: "of both places" }).waitFor();
  await until((one) => one.edit.problem === null, "it can be added all the same");
});

scene("of a place that was passed often each visit can be chosen", {}, async (tools) => {
  const { page, until, state, settle } = tools;
  await until(editable, "shown");
  await page.keyboard.press("5");
  await page.click("#edit-add_closure");
  await clickNode(page, 17);
  const visits = page.locator("#place-0-visit option");
  assert.ok((await visits.count()) >= 2);
  const before = await page.locator("#place-0-node").inputValue();
  const value = (await visits.last().getAttribute("value")) ?? "";
  await page.selectOption("#place-0-visit", value);
  await settle();
  assert.notEqual(await page.locator("#place-0-node").inputValue(), before);
  assert.equal(await page.locator("#place-0-node").inputValue(), value);
  assert.equal((await state()).edit.tool, "add_closure");
});

scene(
  "a stretch is marked before it is ignored",
  {},
  async ({ page, until, picture, settle, server }) => {
    await until(editable, "shown");
    await page.keyboard.press("5");
    await page.click("#edit-ignore");
    const before = await picture();
    const count = run.nodes.length;
    await page.fill("#place-0-time", "2:30");
    await page.keyboard.press("Enter");
    await page.fill("#place-1-time", "2:00");
    await page.keyboard.press("Enter");
    await settle();
    assert.ok(differingShare(before, await picture()) > 0.0005, "it is seen");
    await says(page, "#edit-stretch", /^\d+ key scans, 0:\d\d min, \d+/);
    await page.click("#edit-send");
    await until((one) => kinds(one).length === 1 && drawn(one), "ignored");
    const [from = 0, to = 0] = (server.edits?.asked[0] ?? "").match(/\d+/g)?.map(Number) ?? [];
    assert.ok(from < to && to < count, "whichever end comes first");
    await page.click("#edit-ignore");
    await clickNode(page, 200);
    await clickNode(page, 230);
    await until((one) => one.edit.problem === null, "by clicks, too");
  },
);

scene(
  "straightening and the origin: the frame turns, and what is told goes along",
  {},
  async (tools) => {
    const { page, until, state, server } = tools;
    await until(editable, "shown");
    await page.keyboard.press("5");
    await page.click("#edit-keep_out");
    await drawPolygon(page);
    await page.click("#edit-close");
    await page.click("#edit-send");
    await until((one) => kinds(one).length === 1 && drawn(one), "a zone");
    const before = (await state()).edits?.edits[0]?.polygon ?? [];
    await page.click("#edit-straighten");
    const turned = await until((one) => kinds(one).length === 2 && drawn(one), "straightened");
    assert.ok(!server.edits?.asked[1]?.includes("as_edited"), "it is told on no map");
    const after = turned.edits?.edits[0]?.polygon ?? [];
    assert.ok(Math.abs((after[0] ?? 0) - (before[0] ?? 0)) > 0.01, "the zone goes along");
    await page.click("#edit-straighten");
    await page.locator("#edit-message", { hasText: "Refused: its walls" }).waitFor();
    await until(drawn, "drawn");
    await page.click("#edit-origin");
    await clickAt(page, 20, 10);
    assert.match((await state()).edit.toml, /x_m = (19\.9|20)/);
    assert.ok(!(await state()).edit.toml.includes("yaw"));
    await dragFrom(page, [20, 10], [0, -70]);
    assert.match((await state()).edit.toml, /yaw_rad = 1\.57/);
    await page.locator("#overlay").focus();
    await page.keyboard.press("]");
    assert.match((await state()).edit.toml, /yaw_rad = 1\.48/);
    await page.click("#edit-send");
    await until(
      (one) => one.edits?.edits.at(-1)?.applied === false && one.edit.busy === "",
      "refused",
    );
    await says(page, "#edit-message", /straightened/);
    await until(drawn, "drawn");
    await page.fill("#edit-yaw", "");
    await page.click("#edit-send");
    await until((one) => one.edit.tool === null && kinds(one).length === 3 && drawn(one), "set");
    const node = await nodeOf(page, 0);
    assert.ok(node && node.x < -15, "the path is told from there");
    const { pictures, damaged } = await until(
      (one) => !one.pictures.texture,
      "no floor in this frame",
    );
    assert.deepEqual([pictures.quality, damaged], [false, 0]);
  },
);

scene("a polygon by keyboard alone", {}, async ({ page, until, state }) => {
  await until(editable, "shown");
  await page.keyboard.press("5");
  await page.locator("#edit-crop").focus();
  await page.keyboard.press("Enter");
  assert.equal(await page.evaluate(() => document.activeElement?.id), "overlay");
  for (const key of ["Enter", "ArrowRight", "Enter", "ArrowUp", "Enter", "ArrowLeft", "Enter"])
    await page.keyboard.press(key);
  await page.keyboard.press("Enter");
  const { edit, camera } = await state();
  assert.equal(edit.problem, null, "the last place again closes");
  const numbers = (edit.toml.match(/-?\d+(\.\d+)?/g) ?? []).map(Number);
  assert.equal(numbers.length, 8);
  const width = (numbers[2] ?? 0) - (numbers[0] ?? 0);
  assert.ok(Math.abs(width - 80 / camera.scale) < 1e-4);
  await page.keyboard.press("Backspace");
  await page.keyboard.press("Backspace");
  assert.notEqual((await state()).edit.problem, null);
});

scene("the list is saved, and told how it is repeated", {}, async ({ page, until, server }) => {
  await until(editable, "shown");
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
  await page.keyboard.press("5");
  await says(page, "#edit-saved", /Not saved yet/);
  await page.click("#edit-straighten");
  await until((one) => kinds(one).length === 1, "an edit");
  await page.click("#edit-straighten");
  await until((one) => kinds(one).length === 2 && one.edit.busy === "", "a refused one");
  assert.equal(await page.locator("#edit-save").innerText(), "Save as out.edits.toml");
  await page.click("#edit-save");
  await until((one) => one.edits?.saved === one.edits?.revision, "saved");
  assert.equal(
    server.edits?.written,
    '[[edit]]\nkind = "straighten"\n',
    "without what was refused",
  );
  await page.locator("#live p", { hasText: "Saved as out.edits.toml." }).waitFor();
  await page.click("#edit-undo");
  await page.locator("#edit-saved", { hasText: "Changed since it was saved" }).waitFor();
  await page.click("#edit-copy");
  await page.locator("#edit-message", { hasText: "copied" }).waitFor();
  const copied = await page.evaluate(() => navigator.clipboard.readText());
  assert.equal(copied, "loopstone edit out --edits out.edits.toml -o out2");
});

scene(
  "while the map is drawn the page says so, and takes no polygon",
  { server: { drawDelay: 8000 } }, // a busy machine draws a polygon meanwhile
  async (tools) => {
    const { page, until } = tools;
    await until(editable, "shown");
    await page.keyboard.press("5");
    await says(page, "#edit-drawn", /drawn with all edits/);
    await page.click("#edit-straighten");
    await page.locator("#edit-drawn", { hasText: "being drawn" }).waitFor();
    await page.click("#edit-erase");
    await drawPolygon(page);
    await page.click("#edit-close");
    await page.click("#edit-send");
    await says(page, "#edit-message", /not drawn with the last edit yet/);
    await page.locator("#edit-drawn", { hasText: "drawn with all edits" }).waitFor();
    await page.click("#edit-send");
    await until((one) => kinds(one).length === 2, "then it does");
  },
);

scene(
  "refused requests, answers that are lost or damaged: told, and nothing is lost",
  { expected: /409|413|ERR_|Failed to load/ },
  async (tools) => {
    const { page, until, state, server } = tools;
    await until(editable, "shown");
    await page.keyboard.press("5");
    await page.click("#edit-keep_out");
    await drawPolygon(page);
    await page.click("#edit-close");
    await page.fill("#edit-name", "stairs");
    assert.ok(server.edits);
    server.edits.refuseNext = new BadRequest(409, "another edit is being done; try again");
    await page.click("#edit-send");
    await page.locator("#edit-message", { hasText: "another edit is being done" }).waitFor();
    await page.locator("#live p", { hasText: "another edit is being done" }).waitFor();
    assert.equal((await state()).edit.tool, "keep_out");
    assert.equal(await page.inputValue("#edit-name"), "stairs");
    await page.route("**/api/edits?*", (route) => route.fulfill({ status: 200, body: "{}" }));
    await page.click("#edit-send");
    await page.locator("#edit-message", { hasText: "could not be read" }).waitFor();
    await page.unroute("**/api/edits?*");
    // It is done, and the answer is lost on the way.
    await page.route("**/api/edits?*", async (route) => {
      await route.fetch();
      await route.abort("connectionreset");
    });
    await page.click("#edit-send");
    await page.locator("#edit-message", { hasText: "does not answer" }).waitFor();
    await page.unroute("**/api/edits?*");
    const known = await until((one) => kinds(one).length === 1, "asked for again: it was done");
    assert.equal(known.edit.tool, "keep_out", "what was drawn is still there");
    await page.keyboard.press("Escape");
  },
);

scene(
  "the connection breaks while a polygon is drawn",
  { expected: /WebSocket|ERR_/ },
  async (tools) => {
    const { page, until, server, state } = tools;
    await until(editable, "shown");
    await page.keyboard.press("5");
    await page.click("#edit-straighten");
    await until((one) => kinds(one).length === 1 && drawn(one), "an edit");
    await page.click("#edit-erase");
    await drawPolygon(page);
    server.dropClients();
    await page.locator("#edit-message", { hasText: "No connection" }).waitFor();
    const again = await until((one) => one.connection === "open", "again");
    assert.deepEqual(kinds(again), ["straighten"]);
    assert.equal((await state()).edit.tool, "erase");
    await page.click("#edit-close");
    await page.click("#edit-send");
    await until((one) => kinds(one).length === 2, "sent");
    // Another server, with a list of its own.
    const { port } = server;
    await server.close();
    const other = new DemoServer({ ...run, name: "another run" }, { ...server.options });
    other.sessionId = "demo-2";
    await other.listen(port);
    try {
      await until(
        (one) => one.about?.name === "another run" && one.edits?.edits.length === 0,
        "its list",
      );
    } finally {
      await other.close();
    }
  },
);

scene("what another page does is seen here", {}, async ({ page, until, server, state }) => {
  await until(editable, "shown");
  await page.keyboard.press("5");
  await page.click("#edit-erase");
  await drawPolygon(page, kCorners.slice(0, 2));
  server.edits?.post("/api/edits", { toml: '[[edit]]\nkind = "straighten"\n' });
  await until((one) => kinds(one).length === 1 && drawn(one), "its edit");
  assert.match((await state()).edit.message.text, /has changed since this was begun/);
  assert.equal((await state()).edit.tool, "erase");
});

scene("measuring and tools exclude each other", {}, async ({ page, until, state }) => {
  await until(editable, "shown");
  await page.keyboard.press("m");
  await page.keyboard.press("5");
  await page.click("#edit-erase");
  assert.equal((await state()).measure.active, false);
  await page.keyboard.press("m");
  assert.equal((await state()).measure.active, true);
  assert.equal((await state()).edit.tool, null);
});

scene(
  "everything of the panel has a name, in each tool; the help tells the keys",
  { dark: false },
  async (tools) => {
    const { page, until } = tools;
    await until(editable, "shown");
    await page.keyboard.press("5");
    for (const tool of ["", "add_closure", "ignore", "crop", "speed", "keep_out", "origin"]) {
      if (tool !== "") await page.click(`#edit-${tool}`);
      if (tool === "add_closure") {
        await page.fill("#place-0-time", "0:45");
        await page.fill("#place-1-time", "5:10");
        await page.keyboard.press("Enter");
      }
      const nameless = await page.evaluate(() =>
        [
          ...document.querySelectorAll(
            "#panel-edit :is(button, input, select, [tabindex='0']), #edit-words button",
          ),
        ]
          .filter((one) => one instanceof HTMLElement && one.offsetParent !== null)
          .filter((one) => {
            const labels =
              one instanceof HTMLInputElement || one instanceof HTMLSelectElement
                ? [...(one.labels ?? [])]
                : [];
            return (
              !one.getAttribute("aria-label") &&
              !labels.some((text) => text.innerText) &&
              !(one as HTMLElement).innerText
            );
          })
          .map((one) => one.outerHTML),
      );
      assert.deepEqual(nameless, [], tool);
      const ids = await page.evaluate(() =>
        [...document.querySelectorAll("[id]")].map((one) => one.id),
      );
      assert.equal(new Set(ids).size, ids.length, "ids are unique");
      const wide = await page.evaluate(() => {
        const panel = document.getElementById("panel-edit");
        return panel !== null && panel.scrollWidth > panel.clientWidth;
      });
      assert.equal(wide, false, `${tool} fits`);
      await page.keyboard.press("Escape");
    }
    await page.keyboard.press("?");
    await says(page, "dialog", /Editing[^]*Ctrl\+Z/);
  },
);

scene(
  "on a telephone: the drawer makes room, fingers are enough",
  { phone: true },
  async (tools) => {
    const { page, until, state, settle } = tools;
    await until(editable, "shown");
    await page.tap("#drawer");
    await page.tap("#tab-edit");
    const small = await page.evaluate(() =>
      [...document.querySelectorAll<HTMLElement>("#panel-edit button, .tabs button")]
        .filter((one) => one.offsetParent !== null && one.offsetHeight < 40)
        .map((one) => one.id),
    );
    assert.deepEqual(small, [], "large enough for fingers");
    await page.tap("#edit-speed");
    await page.locator("#side").waitFor({ state: "hidden" });
    await settle();
    for (const [x, y] of kCorners) {
      const at = await screenOf(page, x, y);
      await page.touchscreen.tap(at.x, at.y);
    }
    await page.tap("#edit-words-close");
    await page.tap("#edit-words-next");
    await page.locator("#side.open").waitFor();
    const wide = await page.evaluate(
      () => document.documentElement.scrollWidth > window.innerWidth,
    );
    assert.equal(wide, false);
    await page.tap("#edit-send");
    await until((one) => kinds(one).length === 1 && drawn(one), "added");
    await page.tap("#edit-undo");
    await until((one) => kinds(one).length === 0, "undone");
    assert.equal((await state()).edit.tool, null);
  },
);
