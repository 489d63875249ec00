/** Debian's Chromium without a screen, and a page that tells what goes wrong in it. */
import { existsSync } from "node:fs";
import { type Browser, chromium, type Page } from "playwright-core";
import type { Exposed, PageState } from "../../src/state.ts";

const kPlaces = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];

export function chromiumPath(): string | null {
  return process.env["CHROMIUM"] ?? kPlaces.find((path) => existsSync(path)) ?? null;
}

export async function launch(): Promise<Browser> {
  const executablePath = chromiumPath();
  if (executablePath === null) throw new Error("no Chromium: apt install chromium");
  return chromium.launch({
    executablePath,
    args: [
      "--no-sandbox",
      "--disable-quic",
      "--no-first-run",
      "--disable-background-networking",
      "--use-gl=angle",
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
      "--force-color-profile=srgb",
      "--font-render-hinting=none",
    ],
  });
}

export interface OpenOptions {
  width?: number;
  height?: number;
  dark?: boolean;
  phone?: boolean;
  reducedMotion?: boolean;
}

export interface Opened {
  page: Page;
  /** Errors of the console and of scripts, and requests to others than our own server. */
  faults: string[];
}

export async function open(
  browser: Browser,
  url: string,
  options: OpenOptions = {},
): Promise<Opened> {
  const phone = options.phone ?? false;
  const context = await browser.newContext({
    viewport: {
      width: options.width ?? (phone ? 390 : 1000),
      height: options.height ?? (phone ? 780 : 640),
    },
    colorScheme: (options.dark ?? true) ? "dark" : "light",
    reducedMotion: (options.reducedMotion ?? true) ? "reduce" : "no-preference",
    hasTouch: phone,
    isMobile: phone,
    acceptDownloads: true,
  });
  const page = await context.newPage();
  const faults: string[] = [];
  const host = new URL(url).host;
  page.on("pageerror", (error) => faults.push(`script: ${error.message}`));
  page.on("console", (message) => {
    if (message.type() === "error" || message.type() === "warning") faults.push(message.text());
  });
  page.on("request", (request) => {
    const asked = new URL(request.url());
    if (!["data:", "blob:"].includes(asked.protocol) && asked.host !== host) {
      faults.push(`a request to ${asked.host}`);
    }
  });
  await page.goto(url);
  return { page, faults };
}

type Loopstone = { loopstone: Exposed };

export function stateOf(page: Page): Promise<PageState> {
  return page.evaluate(() => (window as unknown as Loopstone).loopstone.state);
}

/** Waits until the page's state is as wished; tells the last one when it never is. */
export async function until(
  page: Page,
  wish: (state: PageState) => boolean,
  what: string,
  patience = 20_000,
): Promise<PageState> {
  const begin = Date.now();
  for (;;) {
    const state = await stateOf(page);
    if (wish(state)) return state;
    if (Date.now() - begin > patience) throw new Error(`${what}: ${JSON.stringify(state)}`);
    await page.waitForTimeout(30);
  }
}

export async function screenOf(
  page: Page,
  x: number,
  y: number,
): Promise<{ x: number; y: number }> {
  const box = await page.locator("#overlay").boundingBox();
  const at = await page.evaluate(
    ([px, py]) => (window as unknown as Loopstone).loopstone.toScreen(px ?? 0, py ?? 0),
    [x, y],
  );
  return { x: at.x + (box?.x ?? 0), y: at.y + (box?.y ?? 0) };
}

export function nodeOf(page: Page, i: number): Promise<{ x: number; y: number } | null> {
  return page.evaluate((at) => (window as unknown as Loopstone).loopstone.node(at), i);
}

export function measureFrames(page: Page, count: number, refill: boolean): Promise<number[]> {
  return page.evaluate(
    ([n, again]) =>
      (window as unknown as Loopstone).loopstone.measureFrames(n as number, again as boolean),
    [count, refill],
  );
}
