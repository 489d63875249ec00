/** A page of its own for each test, held against a server with a run made by code. */
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { after, before, test } from "node:test";
import type { Browser, Page } from "playwright-core";
import { decodePng } from "../../demo/png.ts";
import { officeRun, type Run } from "../../demo/run.ts";
import { DemoServer, type Options } from "../../demo/server.ts";
import type { PageState } from "../../src/state.ts";
import { launch, open, type OpenOptions, stateOf, until } from "./browser.ts";

let browser: Browser;
export let run: Run;
let html: Buffer;

before(async () => {
  browser = await launch();
  run = officeRun();
  html = await readFile("built/index.html");
});

after(() => browser.close());

export interface Scene {
  page: Page;
  server: DemoServer;
  state(): Promise<PageState>;
  until(wish: (state: PageState) => boolean, what: string): Promise<PageState>;
  picture(): Promise<ReturnType<typeof decodePng>>;
  settle(): Promise<void>;
}

export interface SceneOptions extends OpenOptions {
  server?: Partial<Options>;
  at?: number;
  /** Faults that the test brings about itself. */
  expected?: RegExp;
}

/** A test with a page of its own, which ends without errors and without a request to others. */
export function scene(
  name: string,
  options: SceneOptions,
  act: (scene: Scene) => Promise<void>,
): void {
  test(name, { timeout: 60_000 }, async () => {
    const defaults: Options = {
      mode: "replay",
      page: html,
      token: "secret",
      canSeek: true,
      playing: false,
    };
    const server = new DemoServer(run, { ...defaults, ...options.server });
    await server.listen();
    server.time = server.begin + (options.at ?? 130);
    const { page, faults } = await open(browser, server.url, options);
    const tools: Scene = {
      page,
      server,
      state: () => stateOf(page),
      until: async (wish, what) => {
        const state = await until(page, wish, what);
        await tools.settle();
        return state;
      },
      picture: async () => decodePng(await page.locator(".view").screenshot()),
      settle: () =>
        page.evaluate(
          () =>
            new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done()))),
        ),
    };
    try {
      await act(tools);
      const others = faults.filter((fault) => !options.expected?.test(fault));
      assert.deepEqual(others, [], "errors in the console, or requests to others");
    } finally {
      await page.context().close();
      await server.close();
    }
  });
}

export const shown = (state: PageState) =>
  state.nodes > 1000 &&
  (state.drawn["tiles"] ?? 0) > 0 &&
  state.robot !== null &&
  state.scanPoints > 0 &&
  state.pictures.texture &&
  state.verdict !== null &&
  state.closures > 0 &&
  state.about !== null;
