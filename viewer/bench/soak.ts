/**
 * Uses the page for long, and looks whether its memory grows: npm run soak [-- --minutes 120]
 *
 * A run is mapped again and again, everything that the reader can do is done, the connection is cut
 * now and then. After each minute garbage is collected and the heap measured.
 */
import { readFile } from "node:fs/promises";
import { parseArgs } from "node:util";
import type { CDPSession, Page } from "playwright-core";
import { officeRun } from "../demo/run.ts";
import { DemoServer } from "../demo/server.ts";
import { launch, open, until } from "../tests/support/browser.ts";

const { values } = parseArgs({ options: { minutes: { type: "string", default: "4" } } });
const minutes = Number(values.minutes);
/** How much the end may lie above the begin: share, and megabytes. */
const kGrowth = 1.1;
const kSlack = 1.5;

const server = new DemoServer(officeRun(), {
  mode: "mapping",
  page: await readFile("built/index.html"),
  token: null,
  canSeek: true,
  playing: true,
});
await server.listen();
server.speed = 20;
const browser = await launch();
const { page, faults } = await open(browser, server.url);
await until(page, (state) => state.nodes > 0, "the run");
const client = await page.context().newCDPSession(page);

async function measure(session: CDPSession) {
  await session.send("HeapProfiler.collectGarbage");
  const { usedSize } = await session.send("Runtime.getHeapUsage");
  const { nodes, jsEventListeners } = await session.send("Memory.getDOMCounters");
  return { heap: usedSize / 1e6, nodes, listeners: jsEventListeners };
}

async function use(page: Page, round: number): Promise<void> {
  for (const key of [
    "1",
    "2",
    "n",
    "n",
    "v",
    "z",
    "3",
    "4",
    "f",
    "r",
    "+",
    "-",
    "g",
    "g",
    "t",
    "Escape",
  ]) {
    await page.keyboard.press(key);
    await page.waitForTimeout(60);
  }
  await page.mouse.move(300, 300);
  await page.mouse.wheel(0, round % 2 === 0 ? -200 : 200);
  if (server.status === 3 || round % 40 === 39) {
    server.time = server.begin;
    server.status = 0;
  }
  if (round % 50 === 49) server.dropClients();
}

const measured: { minute: number; heap: number; nodes: number; listeners: number }[] = [];
const begin = Date.now();
const steps = Math.max(8, Math.round(minutes * 2));
let round = 0;
for (let step = 0; step < steps; step++) {
  const end = begin + ((step + 1) / steps) * minutes * 60_000;
  do await use(page, round++);
  while (Date.now() < end);
  const now = { minute: (Date.now() - begin) / 60_000, ...(await measure(client)) };
  measured.push(now);
  console.log(
    `${now.minute.toFixed(1)} min: heap ${now.heap.toFixed(2)} MB, ${now.nodes} nodes, ${now.listeners} listeners`,
  );
}
await browser.close();
await server.close();

const median = (list: number[]) => [...list].sort((a, b) => a - b)[list.length >> 1] ?? NaN;
const third = Math.floor(measured.length / 3);
const early = measured.slice(1, 1 + third);
const late = measured.slice(-third);
const problems: string[] = faults.filter((fault) => !/WebSocket/.test(fault));
for (const name of ["heap", "nodes", "listeners"] as const) {
  const first = median(early.map((one) => one[name]));
  const last = median(late.map((one) => one[name]));
  const slack = name === "heap" ? kSlack : 100;
  if (last > first * kGrowth + slack) problems.push(`${name} grew from ${first} to ${last}`);
  else console.log(`${name}: ${first.toFixed(2)} early, ${last.toFixed(2)} late`);
}
if (problems.length > 0) {
  console.error(problems.join("\n"));
  process.exit(1);
}
console.log(`flat over ${minutes} min, ${round} rounds`);
