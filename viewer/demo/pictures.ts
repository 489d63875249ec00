/** Pictures of the page for docs/: npm run pictures */
import { mkdir, readFile, writeFile } from "node:fs/promises";
import type { Page } from "playwright-core";
import { launch, open, type OpenOptions, until } from "../tests/support/browser.ts";
import { fewerColours } from "./fewer_colours.ts";
import { decodePng } from "./png.ts";
import { officeRun } from "./run.ts";
import { DemoServer } from "./server.ts";

const folder = process.argv[2] ?? "../docs/images";
const page = await readFile("built/index.html");
const options = { mode: "replay", page, token: null, canSeek: true, playing: false } as const;
const server = new DemoServer(officeRun(), options);
await server.listen();
server.time = server.begin + 224;
await mkdir(folder, { recursive: true });
const browser = await launch();

async function take(
  name: string,
  how: OpenOptions,
  act: (page: Page) => Promise<void>,
): Promise<void> {
  const { page, faults } = await open(browser, server.url, how);
  await until(
    page,
    (state) => state.nodes > 0 && state.pictures.texture && state.robot !== null,
    name,
  );
  await act(page);
  await page.waitForTimeout(400);
  const png = await page.screenshot();
  await page.context().close();
  if (faults.length > 0) throw new Error(faults.join("\n"));
  const small = fewerColours(decodePng(png));
  await writeFile(`${folder}/${name}.png`, small);
  console.log(`${folder}/${name}.png, ${small.length} bytes`);
}

const wide = { width: 1200, height: 720 };
await take("live_view", { ...wide, dark: true }, async () => undefined);
await take("live_view_closure", { ...wide, dark: false }, async (page) => {
  await page.click("#tab-closures");
  await page.locator(".table .body .line").nth(4).click();
  await until(page, (state) => state.evidence !== null, "a closure");
});
await take("live_view_phone", { phone: true, dark: true }, async (page) => {
  await page.tap("#drawer");
  await page.tap("#tab-layers");
});
await browser.close();
await server.close();
