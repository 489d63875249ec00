/** The page in a browser, held against a server with a run made by code. */
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { decodePng } from "../demo/png.ts";
import { Random } from "../demo/random.ts";
import { DemoServer } from "../demo/server.ts";
import { kPalettes } from "../src/colours.ts";
import { nodeOf, screenOf, stateOf } from "./support/browser.ts";
import { countOf, differenceFromStored, differingShare } from "./support/images.ts";
import { run, scene, shown } from "./support/scene.ts";

scene("all that the server sends is shown", {}, async ({ page, server, until, settle }) => {
  const state = await until(shown, "shown");
  await settle();
  assert.equal(state.connection, "open");
  assert.equal(state.about?.name, "demo office");
  assert.equal(state.nodes, run.nodes.length);
  assert.equal(state.closures, run.closures.length);
  assert.equal(state.verdict, "doubtful");
  assert.equal(state.warnings, 3);
  assert.equal(state.damaged, 0);
  assert.equal(await page.title(), "demo office – Loopstone");
  assert.equal(await page.locator("#run").innerText(), "demo office");
  assert.equal(await page.locator("#mode").innerText(), "replay");
  assert.match(
    await page.locator("#verdict").innerText(),
    /Doubtful[^]*visits agree[^]*north-east/,
  );
  assert.match(await page.locator("#status").innerText(), /tracked|degenerate|bridged/);
  assert.ok(
    server.requests.some((url) => url === "/?token=secret"),
    "the token goes to the socket",
  );
  assert.ok(server.requests.some((url) => url === "/api/about?token=secret"));
});

scene("robot and scan lie where they should", {}, async ({ page, until, picture, settle }) => {
  const state = await until(shown, "shown");
  for (const layer of ["texture", "path", "closures"])
    await page.evaluate((id) => document.getElementById(`layer-${id}`)?.click(), layer);
  await settle();
  const image = await picture();
  const view = await page.locator("#overlay").boundingBox();
  const scan = kPalettes.dark.scan.map((c) => Math.round(255 * c)) as [number, number, number];
  assert.ok(countOf(image, scan) > 300, "points of the scan");
  const at = await screenOf(page, state.robot?.pose.x ?? 0, state.robot?.pose.y ?? 0);
  const robot = await page.screenshot({
    clip: { x: at.x - 12, y: at.y - 12, width: 24, height: 24 },
  });
  assert.ok(countOf(decodePng(robot), [255, 255, 255]) > 30, "the robot");
  assert.ok(view !== null);
});

scene(
  "every layer can be switched, and is drawn or not",
  {},
  async ({ page, until, picture, settle, state }) => {
    await until(shown, "shown");
    await page.click("#tab-layers");
    let last = await picture();
    for (const layer of [
      "map",
      "grid",
      "texture",
      "quality",
      "submaps",
      "path",
      "closures",
      "scan",
      "robot",
      "places",
    ] as const) {
      const before = (await state()).layers[layer];
      await page.click(`#layer-${layer}`);
      if (layer === "quality") await until((now) => now.pictures.quality, "the quality layer");
      await settle();
      assert.equal((await state()).layers[layer], !before);
      const now = await picture();
      assert.ok(differingShare(last, now) > 0.0001, `${layer} changes the picture`);
      last = now;
    }
    await page.reload();
    const after = await until((now) => now.nodes > 0, "again");
    assert.equal(after.layers.map, false, "the choice is remembered");
    assert.equal(after.layers.quality, true);
  },
);

scene("opacity", {}, async ({ page, until, picture, settle, state }) => {
  await until(shown, "shown");
  await page.click("#tab-layers");
  for (const name of ["map", "texture"] as const) {
    const before = await picture();
    await page.locator(`#opacity-${name}`).fill("20");
    await settle();
    assert.equal((await state()).opacity[name], 0.2);
    assert.ok(differingShare(before, await picture()) > 0.005, name);
  }
});

scene(
  "the path is coloured by time, uncertainty or drive",
  {},
  async ({ page, until, settle, state, picture }) => {
    await until(shown, "shown");
    await page.click("#tab-layers");
    for (const layer of ["closures", "texture", "scan", "robot"])
      await page.click(`#layer-${layer}`);
    const pictures = [await picture()];
    for (const by of ["uncertainty", "drive"]) {
      await page.locator(`input[name=path-colour][value=${by}]`).click();
      await settle();
      assert.equal((await state()).pathColour, by);
      pictures.push(await picture());
    }
    const [time, uncertainty, drive] = pictures;
    assert.ok(time && uncertainty && drive);
    assert.ok(differingShare(time, uncertainty) > 0.001);
    assert.ok(differingShare(uncertainty, drive) > 0.001);
    const [first = ""] = kPalettes.dark.drives;
    const colour = [1, 3, 5].map((i) => Number.parseInt(first.slice(i, i + 2), 16)) as [
      number,
      number,
      number,
    ];
    assert.ok(countOf(drive, colour) > 500, "the first drive in its colour");
  },
);

scene(
  "the mouse pans, zooms where it points, turns; fit and north undo it",
  {},
  async ({ page, until, state }) => {
    await until(shown, "shown");
    const place = { x: 20, y: 8 };
    const at = await screenOf(page, place.x, place.y);
    await page.mouse.move(at.x, at.y);
    await page.mouse.down();
    await page.mouse.move(at.x + 60, at.y - 40, { steps: 4 });
    await page.mouse.up();
    let now = await screenOf(page, place.x, place.y);
    assert.ok(
      Math.abs(now.x - at.x - 60) < 1.5 && Math.abs(now.y - at.y + 40) < 1.5,
      JSON.stringify(now),
    );
    assert.equal((await state()).mode, "free");
    const { scale } = (await state()).camera;
    await page.mouse.wheel(0, -300);
    await until((one) => one.camera.scale > scale * 1.3, "zoomed in");
    now = await screenOf(page, place.x, place.y);
    assert.ok(
      Math.abs(now.x - at.x - 60) < 1.5 && Math.abs(now.y - at.y + 40) < 1.5,
      "what is pointed at stays",
    );
    await page.keyboard.down("Shift");
    await page.mouse.down();
    await page.mouse.move(at.x + 60, at.y + 120, { steps: 4 });
    await page.mouse.up();
    await page.keyboard.up("Shift");
    assert.ok(Math.abs((await state()).camera.angle) > 0.05, "turned");
    await page.click("#tool-north");
    await until((one) => one.camera.angle === 0, "north up");
    await page.click("#tool-in");
    await page.click("#tool-out");
    await page.click("#tool-fit");
    const fitted = await until((one) => one.mode === "fit", "fit");
    assert.equal(await page.getAttribute("#tool-fit", "aria-pressed"), "true");
    await until(
      (one) => Math.abs(one.camera.scale - scale) < scale * 0.05,
      `as at first: ${JSON.stringify(fitted.camera)}`,
    );
  },
);

scene(
  "following keeps the robot in the middle",
  { server: { playing: true } },
  async ({ page, until, state }) => {
    await until(shown, "shown");
    await page.click("#tool-follow");
    for (let i = 0; i < 5; i++) {
      await page.waitForTimeout(120);
      const { camera, robot, mode } = await state();
      assert.equal(mode, "follow");
      assert.ok(Math.hypot(camera.x - (robot?.pose.x ?? 0), camera.y - (robot?.pose.y ?? 0)) < 0.5);
    }
    await page.click("#tool-follow");
    assert.equal((await state()).mode, "free");
  },
);

scene("measuring", {}, async ({ page, until, state }) => {
  await until(shown, "shown");
  await page.keyboard.press("m");
  for (const [x, y] of [
    [10, 12],
    [13, 16],
    [13, 18],
  ] as const) {
    const at = await screenOf(page, x, y);
    await page.mouse.click(at.x, at.y);
  }
  const { measure } = await state();
  assert.equal(measure.points.length, 3);
  assert.ok(Math.abs(measure.total - 7) < 0.15, String(measure.total));
  assert.match(
    await page.locator("#measure-words").innerText(),
    /7\.\d\d m in all, last .* at (89|90)\.\d°/,
  );
  await page.keyboard.press("Backspace");
  assert.equal((await state()).measure.points.length, 2);
  await page.keyboard.press("Escape");
  assert.equal((await state()).measure.active, false);
  assert.ok(await page.locator("#measure-words").isHidden());
});

scene("the pointer's place on the map is told", {}, async ({ page, until }) => {
  await until(shown, "shown");
  const at = await screenOf(page, 12, 5);
  await page.mouse.move(at.x, at.y);
  const [x, y] =
    (await page.locator("#readout").innerText()).match(/-?\d+\.\d+/g)?.map(Number) ?? [];
  assert.ok(Math.abs((x ?? 0) - 12) < 0.1 && Math.abs((y ?? 0) - 5) < 0.1);
});

scene(
  "a closure is chosen on the map, told, compared, zoomed to, closed",
  {},
  async ({ page, until, state }) => {
    await until(shown, "shown");
    const closure = run.closures.find((one) => one.state === "standing");
    assert.ok(closure);
    const from = await nodeOf(page, closure.from);
    const to = await nodeOf(page, closure.to);
    assert.ok(from && to);
    const at = await screenOf(page, (from.x + to.x) / 2, (from.y + to.y) / 2);
    await page.mouse.click(at.x, at.y);
    const { selected, tab } = await until(
      (one) => one.selected !== null && one.evidence === one.selected,
      "chosen",
    );
    assert.equal(tab, "closures");
    const detail = page.locator(".detail");
    assert.match(
      await detail.innerText(),
      new RegExp(`Closure ${selected}, [^]*score[^]*overlap[^]*χ²`),
    );
    const canvas = detail.locator("canvas");
    const measured = await canvas.screenshot();
    await page.locator("text=as the graph has it").click();
    assert.equal((await state()).asMeasured, false);
    const graph = await canvas.screenshot();
    assert.ok(countOf(decodePng(measured), [0x56, 0xb4, 0xe9]) > 20, "points of the first scan");
    assert.ok(countOf(decodePng(graph), [0xe6, 0x9f, 0x00]) > 20, "points of the second scan");
    const { scale } = (await state()).camera;
    await detail.getByRole("button", { name: "Zoom to it" }).click();
    await until((one) => one.camera.scale > scale * 1.2, "zoomed to it");
    await detail.getByRole("button", { name: "Next closure" }).click();
    await until((one) => one.selected !== null && one.selected !== selected, "the next");
    await detail.getByRole("button", { name: "Close" }).click();
    assert.equal((await state()).selected, null);
    assert.ok(await detail.isHidden());
  },
);

scene(
  "the list of closures: sorted, filtered, by keyboard",
  {},
  async ({ page, until, state, picture, settle }) => {
    await until(shown, "shown");
    await page.click("#tab-closures");
    const ids = () => page.locator(".table .body .line > :first-child").allInnerTexts();
    const ascending = (await ids()).map(Number);
    assert.deepEqual(
      ascending,
      [...ascending].sort((a, b) => a - b),
    );
    await page.getByRole("button", { name: "id", exact: true }).click();
    assert.equal(await page.locator("[aria-sort=descending]").innerText(), "id");
    const descending = (await ids()).map(Number);
    assert.ok((descending[0] ?? 0) > (descending[1] ?? 0));
    for (const name of ["score", "overlap", "σ", "time", "state"]) {
      await page.getByRole("button", { name, exact: true }).click();
      assert.equal(await page.locator("[aria-sort=ascending]").innerText(), name);
    }
    const before = await picture();
    for (const word of ["standing", "waiting", "revoked"])
      await page.locator(`[data-state=${word}] input`).click();
    await settle();
    assert.equal((await state()).drawn["closures"], 0);
    assert.ok(differingShare(before, await picture()) > 0.0002);
    assert.match(await page.locator("#panel-closures > .empty").innerText(), /None of the shown/);
    await page.locator("[data-state=rejected] input").click();
    const rejected = run.closures.filter((one) => one.state === "rejected").length;
    await until((one) => one.drawn["closures"] === rejected, "the rejected ones");
    await page.locator(".table").focus();
    await page.keyboard.press("ArrowDown");
    const first = await until((one) => one.selected !== null, "chosen by keyboard");
    await page.keyboard.press("End");
    const last = await until((one) => one.selected !== first.selected, "the last");
    assert.equal(
      await page.locator(".table").getAttribute("aria-activedescendant"),
      `closure-${last.selected}`,
    );
    assert.match(await page.locator(".detail .reason").innerText(), /\w+/);
  },
);

scene(
  "a closure whose scans are not there says so",
  { expected: /404/ },
  async ({ page, until }) => {
    await page.route("**/api/closures/**", (route) =>
      route.fulfill({ status: 404, body: '{"error":"no such closure"}' }),
    );
    await until(shown, "shown");
    await page.keyboard.press("2");
    await page.keyboard.press("n");
    await page.locator(".detail >> text=were not kept").waitFor();
  },
);

scene("places of the verdict: on the map and in the list", {}, async ({ page, until }) => {
  await until(shown, "shown");
  assert.equal(await page.locator(".place").count(), 2);
  const marker = page.locator(".place").first();
  assert.match((await marker.getAttribute("aria-label")) ?? "", /hangs on one recognised place/);
  await marker.click();
  await until(
    (one) => Math.hypot(one.camera.x - 38.5, one.camera.y - 18.5) < 0.1,
    "gone to the first",
  );
  await page.locator(".place-list button").nth(1).click();
  await until(
    (one) => Math.hypot(one.camera.x - 21, one.camera.y - 12) < 0.1,
    "gone to the second",
  );
});

scene("a click on a warning's time goes there", {}, async ({ page, until, server }) => {
  await until(shown, "shown");
  await page.locator(".warnings button").first().click();
  await until((one) => Math.abs((one.playback.time ?? 0) - server.begin - 61.4) < 0.01, "there");
  assert.ok(Math.abs((server.controls.at(-1)?.seek ?? 0) - server.begin - 61.4) < 0.01);
  const focused = await page.evaluate(() => document.activeElement?.getAttribute("aria-label"));
  assert.equal(focused, "Go to 1:01", "the focus stays");
});

scene("play, pause, speed, steps, slider, end", {}, async ({ page, until, server }) => {
  await until(shown, "shown");
  await page.click("#play");
  await until((one) => one.playback.status === "playing", "playing");
  const { playback } = await stateOf(page);
  await until((one) => (one.playback.time ?? 0) > (playback.time ?? 0) + 0.1, "time goes on");
  assert.equal(await page.getAttribute("#play", "aria-label"), "Pause");
  await page.locator("#speed").selectOption("20");
  await until((one) => one.playback.speed === 20, "twenty times");
  await page.click("#play");
  await until((one) => one.playback.status === "paused", "paused");
  const paused = (await stateOf(page)).playback.time ?? 0;
  await page.click("#step-forward");
  const next = await until((one) => (one.playback.time ?? 0) > paused, "a step on");
  assert.ok(
    run.nodes.some((node) => Math.abs(node.t - (next.playback.time ?? 0)) < 1e-3),
    "to a key scan",
  );
  await page.click("#step-back");
  await until((one) => (one.playback.time ?? 0) < (next.playback.time ?? 0), "a step back");
  await page.locator("#slider").fill("5000");
  const middle = (server.begin + server.end) / 2;
  await until((one) => Math.abs((one.playback.time ?? 0) - middle) < 0.2, "the middle");
  await page.locator("#slider").focus();
  await page.keyboard.press("End");
  await until((one) => Math.abs((one.playback.time ?? 0) - server.end) < 0.2, "the end");
  await page.click("#play");
  await until((one) => one.playback.status === "ended", "ended");
  await page.click("#play");
  await until((one) => (one.playback.time ?? 0) < server.begin + 60, "from the start again");
  assert.equal(server.controls.at(-1)?.seek, server.begin);
});

scene(
  "a click into a plot goes there; the pointer tells the value",
  { server: { playing: true } },
  async ({ page, until, server }) => {
    await until((one) => shown(one) && one.figures.length >= 6, "figures");
    await page.click("#tab-plots");
    const plot = page.locator(".plot canvas").first();
    await page.waitForTimeout(900);
    assert.equal(await page.locator(".plot").count(), 4);
    await plot.hover({ position: { x: 60, y: 30 } });
    await page
      .locator(".plot figcaption b")
      .first()
      .filter({ hasText: /at \d+:\d\d/ })
      .waitFor();
    assert.ok(
      countOf(decodePng(await plot.screenshot()), [0x7a, 0xb0, 0xff], 40) > 20,
      "the curve",
    );
    await plot.click({ position: { x: 150, y: 30 } });
    assert.ok(server.controls.at(-1)?.seek, "a click goes there");
    await plot.focus();
    await page.keyboard.press("Home");
    await page.keyboard.press("ArrowRight");
    await page.keyboard.press("Enter");
    await page.waitForTimeout(300);
    const span = server.time - server.begin;
    assert.ok(span < 140, `gone near the first value by keyboard, not to ${span}`);
    await page.locator(".row input[value=memory_mb]").click();
    await page.locator(".plot[data-name=memory_mb]").waitFor();
    await page.locator(".row input[value=overlap]").click();
    await page.locator(".plot[data-name=overlap]").waitFor({ state: "detached" });
  },
);

scene("all by keyboard", {}, async ({ page, until, state, server }) => {
  await until(shown, "shown");
  await page.locator("#overlay").focus();
  const start = (await state()).camera;
  await page.keyboard.press("ArrowRight");
  await until((one) => one.camera.x > start.x, "right");
  await page.keyboard.press("ArrowUp");
  await until((one) => one.camera.y > start.y, "up");
  await page.keyboard.press("+");
  await until((one) => one.camera.scale > start.scale, "in");
  await page.keyboard.press("-");
  await page.keyboard.press("[");
  await until((one) => one.camera.angle > 0.1, "turned");
  await page.keyboard.press("0");
  await until((one) => one.camera.angle === 0, "north");
  await page.keyboard.press("f");
  await until((one) => one.mode === "fit", "fit");
  await page.keyboard.press("r");
  await until((one) => one.mode === "follow", "follow");
  await page.keyboard.press("g");
  await until((one) => !one.layers.grid, "no grid");
  await page.keyboard.press("m");
  await page.keyboard.press("Enter");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Enter");
  const { measure, camera } = await state();
  assert.ok(Math.abs(measure.total - 80 / camera.scale) < 1e-6, "measured by keyboard");
  await page.keyboard.press("Escape");
  for (const [key, tab] of [
    ["2", "closures"],
    ["3", "layers"],
    ["4", "plots"],
    ["1", "overview"],
  ] as const) {
    await page.keyboard.press(key);
    assert.equal((await state()).tab, tab);
  }
  await page.keyboard.press("n");
  const one = await until((now) => now.selected !== null, "a closure");
  await page.keyboard.press("n");
  await until((now) => now.selected !== one.selected, "the next");
  await page.keyboard.press("b");
  await until((now) => now.selected === one.selected, "the one before");
  await page.keyboard.press("v");
  assert.equal((await state()).asMeasured, false);
  await page.keyboard.press("z");
  await page.keyboard.press("Escape");
  assert.equal((await state()).selected, null);
  await page.keyboard.press(" ");
  await until((now) => now.playback.status === "playing", "playing");
  await page.keyboard.press(">");
  await until((now) => now.playback.speed === 2, "faster");
  await page.keyboard.press("<");
  await until((now) => now.playback.speed === 1, "slower");
  await page.keyboard.press(".");
  await until((now) => now.playback.status === "paused", "a step pauses");
  const before = (await state()).playback.time ?? 0;
  await page.keyboard.press("Shift+ArrowRight");
  await until((now) => Math.abs((now.playback.time ?? 0) - before - 10) < 0.5, "ten seconds on");
  const asked = server.controls.length;
  await page.keyboard.press(",");
  await until(() => server.controls.length > asked, "a step back is asked for");
  await page.keyboard.press("?");
  await page.locator("dialog[open]").waitFor();
  await page.keyboard.press("Escape");
  await page.locator("dialog[open]").waitFor({ state: "hidden" });
});

scene(
  "tab goes through everything in order, arrows from panel to panel",
  {},
  async ({ page, until, state }) => {
    await until(shown, "shown");
    const seen: string[] = [];
    for (let i = 0; i < 40; i++) {
      await page.keyboard.press("Tab");
      seen.push(
        await page.evaluate(
          () => document.activeElement?.id || document.activeElement?.className || "",
        ),
      );
    }
    const order = [
      "skip",
      "screenshot",
      "theme",
      "help-open",
      "overlay",
      "place",
      "tool-fit",
      "tab-overview",
      "step-back",
      "play",
      "slider",
      "speed",
    ];
    const places = order.map((name) =>
      seen.findIndex((one) => one === name || one.startsWith(`${name} `)),
    );
    assert.ok(
      places.every((place) => place >= 0),
      JSON.stringify(seen),
    );
    assert.deepEqual(
      places,
      [...places].sort((a, b) => a - b),
      JSON.stringify(seen),
    );
    await page.locator("#tab-overview").focus();
    await page.keyboard.press("ArrowRight");
    assert.equal((await state()).tab, "closures");
    await page.keyboard.press("End");
    assert.equal((await state()).tab, "plots");
  },
);

scene(
  "everything that can be worked has a name; states are told",
  {},
  async ({ page, until, server }) => {
    await until(shown, "shown");
    for (const tab of ["overview", "closures", "layers", "plots"]) {
      await page.click(`#tab-${tab}`);
      const nameless = await page.evaluate(() =>
        [...document.querySelectorAll("button, input, select, [role=grid], [tabindex='0']")]
          .filter((one) => one instanceof HTMLElement && one.offsetParent !== null)
          .filter((one) => {
            const labels =
              one instanceof HTMLInputElement || one instanceof HTMLSelectElement
                ? [...(one.labels ?? [])]
                : [];
            const label = one.getAttribute("aria-label") ?? one.getAttribute("aria-labelledby");
            return (
              !label && !labels.some((text) => text.innerText) && !(one as HTMLElement).innerText
            );
          })
          .map((one) => one.outerHTML),
      );
      assert.deepEqual(nameless, []);
    }
    const ids = await page.evaluate(() =>
      [...document.querySelectorAll("[id]")].map((one) => one.id),
    );
    assert.equal(new Set(ids).size, ids.length, "ids are unique");
    server.dropClients();
    await page.locator("#live p", { hasText: "Connection lost" }).waitFor();
    await page.locator("#live p", { hasText: "Connected" }).waitFor();
  },
);

scene(
  "theme: as the system, switched, remembered",
  { dark: false },
  async ({ page, until, picture }) => {
    await until((one) => shown(one) && one.theme === "light", "light as the system");
    const light = await picture();
    await page.emulateMedia({ colorScheme: "dark" });
    await until((one) => one.theme === "dark", "dark as the system");
    assert.ok(differingShare(light, await picture()) > 0.3);
    await page.emulateMedia({ colorScheme: "light" });
    await page.click("#theme");
    await until((one) => one.theme === "dark", "switched");
    await page.reload();
    await until((one) => one.theme === "dark", "remembered");
    await page.keyboard.press("t");
    await until((one) => one.theme === "light", "light");
  },
);

scene("a picture of the map can be saved", {}, async ({ page, until }) => {
  await until(shown, "shown");
  const [download] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("p")]);
  assert.equal(download.suggestedFilename(), "demo_office.png");
  const image = decodePng(await readFile(await download.path()));
  const view = await page.locator("#overlay").boundingBox();
  assert.equal(image.width, Math.round(view?.width ?? 0));
  const free = kPalettes.dark.free.map((c) => Math.round(255 * c)) as [number, number, number];
  assert.ok(countOf(image, free, 8) > 0.1 * image.width * image.height, "the map is on it");
});

scene(
  "a lost connection is told, and made again",
  { expected: /WebSocket|ERR_/ },
  async ({ page, until, server }) => {
    await until(shown, "shown");
    const { port } = server;
    server.dropClients();
    await until((one) => one.connection === "open" && one.nodes > 0, "again");
    await server.close();
    await page.locator("#banner", { hasText: /Connection lost.*Next try in \d+ s/ }).waitFor();
    assert.equal(await page.locator("#connection").innerText(), "connection lost");
    assert.ok((await stateOf(page)).nodes > 0, "what was known stays");
    const again = new DemoServer(
      { ...run, name: "another run", closures: [] },
      { ...server.options },
    );
    again.sessionId = "demo-2";
    await again.listen(port);
    try {
      // Or the page was faster by itself.
      await page
        .locator("#banner button")
        .click({ timeout: 2000 })
        .catch(() => undefined);
      await until(
        (one) =>
          one.connection === "open" && one.about?.name === "another run" && one.closures === 0,
        "another run",
      );
      assert.ok(await page.locator("#banner").isHidden());
    } finally {
      await again.close();
    }
  },
);

scene(
  "without the token: why, and what to do",
  { expected: /403|WebSocket/, server: { token: "other" } },
  async ({ page, server }) => {
    await page.goto(`http://127.0.0.1:${server.port}/?token=wrong`);
    await page.locator("#notice", { hasText: "the token is missing or wrong" }).waitFor();
    assert.equal(await page.locator("#connection").innerText(), "refused");
    await page.locator("#notice button").click();
  },
);

scene("connected, and nothing to see yet", {}, async ({ page, until }) => {
  await page.addInitScript(() => {
    const send = WebSocket.prototype.send;
    WebSocket.prototype.send = function (data) {
      if (typeof data !== "string" || !data.includes("subscribe")) send.call(this, data);
    };
  });
  await page.reload();
  await until((one) => one.connection === "open", "open");
  await page.locator("#notice", { hasText: "nothing to see yet" }).waitFor();
});

scene(
  "while it is mapped, the path grows",
  { server: { mode: "mapping", playing: true }, at: 20 },
  async ({ until }) => {
    const first = await until((one) => one.nodes > 10, "nodes");
    await until((one) => one.nodes > first.nodes + 3, "more nodes");
  },
);

scene(
  "localising: particles, no player",
  { server: { mode: "localizing", canSeek: false, playing: true } },
  async ({ page, until }) => {
    const state = await until((one) => one.particles === 500 && one.about !== null, "particles");
    assert.equal(state.playback.canSeek, false);
    assert.ok(await page.locator(".player").isHidden());
    await page.locator("#tracking", { hasText: /TRACKING|DOUBTFUL|LOST/ }).waitFor();
    assert.equal(await page.locator("#mode").innerText(), "localising");
  },
);

scene("nothing is drawn while nothing changes", {}, async ({ page, until, state }) => {
  await until(shown, "shown");
  await page.waitForTimeout(500);
  const { frames } = await state();
  await page.waitForTimeout(1000);
  assert.equal((await state()).frames, frames);
});

scene("whatever the server sends, the page goes on", {}, async ({ page, until, server, state }) => {
  await until(shown, "shown");
  const random = new Random(31);
  for (let i = 0; i < 400; i++) {
    const bytes = Uint8Array.from({ length: random.integer(300) }, () => random.integer(256));
    if (i % 3 === 0) server.sendRaw(bytes);
    else if (i % 3 === 1)
      server.sendRaw(`{"op":"status","level":1,"message":${i % 2 ? "5" : '"m"'}}`);
    else
      server.publish(
        ["/scan", "/loopstone/tiles", "/loopstone/status", "/tf"][random.integer(4)] ?? "",
        bytes,
      );
  }
  await until((one) => one.damaged > 20, "damage is counted");
  assert.ok((await state()).notes.some((note) => note.includes("could not be read")));
  await page.click("#play");
  await until((one) => one.playback.status === "playing", "it still works");
});

scene(
  "a lost drawing context is made again",
  { expected: /CONTEXT_LOST|context/i },
  async ({ page, until, picture, settle }) => {
    await until(shown, "shown");
    await settle();
    const before = await picture();
    await page.evaluate(async () => {
      const gl = (document.getElementById("map") as HTMLCanvasElement).getContext("webgl2");
      const extension = gl?.getExtension("WEBGL_lose_context");
      extension?.loseContext();
      await new Promise((done) => setTimeout(done, 200));
      extension?.restoreContext();
    });
    await until((one) => (one.drawn["tiles"] ?? 0) > 0 && one.pictures.texture, "tiles again");
    await page.waitForTimeout(200);
    assert.ok(differingShare(before, await picture()) < 0.01);
  },
);

scene(
  "a telephone: drawer, no scrolling aside, two fingers",
  { phone: true },
  async ({ page, until, state }) => {
    await until(shown, "shown");
    const wide = await page.evaluate(
      () => document.documentElement.scrollWidth > window.innerWidth,
    );
    assert.equal(wide, false);
    assert.ok(await page.locator("#side").isHidden());
    await page.tap("#drawer");
    await page.locator("#side.open").waitFor();
    assert.equal(await page.getAttribute("#drawer", "aria-expanded"), "true");
    await page.tap("#tab-closures");
    await page.locator(".table .body .line").first().tap();
    await until((one) => one.selected !== null && one.evidence === one.selected, "a closure");
    const closure = run.closures.find((one) => one.state !== "rejected");
    const node = await nodeOf(page, closure?.from ?? 0);
    const at = await screenOf(page, node?.x ?? 0, node?.y ?? 0);
    const top = (await page.locator("#side").boundingBox())?.y ?? 0;
    assert.ok(at.y < top, "what was chosen is above the drawer");
    await page.tap("#drawer");
    await page.locator("#side").waitFor({ state: "hidden" });
    const small = await page.evaluate(() =>
      [...document.querySelectorAll<HTMLElement>(".tools button, .player button, .bar button")]
        .filter(
          (one) => one.offsetParent !== null && (one.offsetWidth < 40 || one.offsetHeight < 40),
        )
        .map((one) => one.id),
    );
    assert.deepEqual(small, [], "large enough for fingers");
    const client = await page.context().newCDPSession(page);
    const touch = (type: string, apart: number) =>
      client.send("Input.dispatchTouchEvent", {
        type: type as "touchStart",
        touchPoints:
          apart === 0 ? [] : [-1, 1].map((side, id) => ({ x: 200 + side * apart, y: 400, id })),
      });
    const { scale } = (await state()).camera;
    await touch("touchStart", 30);
    for (const apart of [40, 55, 70, 90]) await touch("touchMove", apart);
    await touch("touchEnd", 0);
    await until((one) => one.camera.scale > scale * 2, "two fingers zoom");
  },
);

for (const [name, options] of [
  ["dark", { dark: true }],
  ["light", { dark: false }],
  ["phone", { dark: true, phone: true }],
] as const) {
  scene(`looks as it did: ${name}`, options, async ({ page, until, settle }) => {
    await until((one) => shown(one) && one.mode === "fit", "shown");
    await settle();
    await page.waitForTimeout(300);
    const share = await differenceFromStored(name, await page.screenshot());
    assert.ok(
      share < 0.02,
      `${(share * 100).toFixed(2)} % of the pixels differ; see build/viewer/${name}.png`,
    );
  });
}
