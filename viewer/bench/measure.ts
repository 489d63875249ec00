/** Measures the page in a browser and prints figures as JSON: see bench/viewer.py. */
import { readFile } from "node:fs/promises";
import { gzipSync } from "node:zlib";
import type { Browser, Page } from "playwright-core";
import { largeRun, officeRun, type Run } from "../demo/run.ts";
import { DemoServer } from "../demo/server.ts";
import {
  chromiumPath,
  launch,
  measureFrames,
  open,
  stateOf,
  until,
} from "../tests/support/browser.ts";

const quick = process.argv.includes("--quick");
const kPaints = quick ? 3 : 15;
const kFrames = quick ? 10 : 60;
const html = await readFile("built/index.html");

function quantile(values: number[], share: number): number {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? NaN;
}

async function serve(run: Run): Promise<DemoServer> {
  const server = new DemoServer(run, {
    mode: "replay",
    page: html,
    token: null,
    canSeek: true,
    playing: false,
  });
  await server.listen();
  return server;
}

/** From the begin of loading to the first words on the screen [ms]. */
async function firstPaint(page: Page): Promise<number> {
  return page.evaluate(
    () =>
      new Promise<number>((done) => {
        const look = () => {
          const entry = performance.getEntriesByName("first-contentful-paint")[0];
          if (entry) done(entry.startTime);
          else setTimeout(look, 20);
        };
        look();
      }),
  );
}

async function paints(browser: Browser, url: string): Promise<number[]> {
  const times: number[] = [];
  for (let i = 0; i < kPaints; i++) {
    const { page } = await open(browser, url, { width: 1280, height: 800 });
    times.push(await firstPaint(page));
    await page.context().close();
  }
  return times;
}

interface Frames {
  view: string;
  median: number;
  slow: number;
}

async function frames(page: Page, view: string, refill: boolean): Promise<Frames> {
  await measureFrames(page, 3, refill);
  const times = await measureFrames(page, kFrames, refill);
  return { view, median: quantile(times, 0.5), slow: quantile(times, 0.95) };
}

async function heapOf(page: Page): Promise<number> {
  const client = await page.context().newCDPSession(page);
  await client.send("HeapProfiler.collectGarbage");
  const { usedSize } = await client.send("Runtime.getHeapUsage");
  return usedSize;
}

async function measureRun(browser: Browser, run: Run) {
  const server = await serve(run);
  const paint = await paints(browser, server.url);
  const begin = Date.now();
  const { page, faults } = await open(browser, server.url, { width: 1280, height: 800 });
  const wanted = run.tiles().cells.length;
  await until(
    page,
    (state) => state.drawn["tiles"] === wanted && state.nodes === run.nodes.length,
    "shown",
    60_000,
  );
  const loaded = Date.now() - begin;
  // All states of closures, and submaps, so that everything is drawn.
  await page.evaluate(() => {
    document.querySelector<HTMLElement>("[data-state=rejected] input")?.click();
    document.getElementById("layer-submaps")?.click();
  });
  await until(page, (state) => state.drawn["closures"] === run.closures.length, "closures", 20_000);
  const all = await frames(page, "all of it", false);
  const filled = await frames(page, "all of it, every buffer filled anew", true);
  for (let i = 0; i < 7; i++) await page.keyboard.press("+");
  await page.waitForTimeout(300);
  const near = await frames(page, "a part of it", false);
  const { drawn } = await stateOf(page);
  const heap = await heapOf(page);
  if (faults.length > 0) throw new Error(faults.join("; "));
  await page.context().close();
  await server.close();
  const cells = wanted * run.size ** 2;
  return {
    name: run.name,
    area_m2: cells * run.resolution ** 2,
    resolution_m: run.resolution,
    tiles: wanted,
    nodes: run.nodes.length,
    closures: run.closures.length,
    drawn,
    first_paint_ms: { median: quantile(paint, 0.5), slow: quantile(paint, 0.95) },
    loaded_ms: loaded,
    heap_mb: heap / 1e6,
    frames: [all, filled, near],
  };
}

const browser = await launch();
const figures = {
  browser: `Chromium ${browser.version()}`,
  chromium: chromiumPath(),
  page_bytes: html.length,
  page_gzip_bytes: gzipSync(html).length,
  runs: [await measureRun(browser, officeRun()), await measureRun(browser, largeRun())],
};
await browser.close();
console.log(JSON.stringify(figures, null, 1));
