import { readFile } from "node:fs/promises";
import { officeRun } from "./run.ts";
import { DemoServer } from "./server.ts";
import { launch, open, stateOf, until } from "../tests/support/browser.ts";

const page = await readFile("built/index.html");
const out = process.argv[2] ?? "/tmp/look";
const server = new DemoServer(officeRun(), {
  mode: "replay",
  page,
  token: "abc",
  canSeek: true,
  playing: false,
});
await server.listen();
server.time = server.begin + 130;
const browser = await launch();
async function shot(
  name: string,
  options: object,
  act: (page: import("playwright-core").Page) => Promise<void> = async () => {},
) {
  const opened = await open(browser, server.url, options);
  await until(opened.page, (s) => s.nodes > 0 && s.drawn["tiles"]! > 0 && s.robot !== null, name);
  await act(opened.page);
  await opened.page.waitForTimeout(300);
  await opened.page.screenshot({ path: `${out}/${name}.png` });
  console.log(
    name,
    JSON.stringify(opened.faults),
    JSON.stringify((await stateOf(opened.page)).drawn),
  );
  await opened.page.context().close();
}
await shot("dark", { dark: true });
await shot("light", { dark: false });
await shot("closure", { dark: true }, async (p) => {
  await p.click("#tab-closures");
  await p.locator(".table .body .line").nth(3).click();
  await p.waitForTimeout(500);
});
await shot("layers", { dark: false }, async (p) => {
  await p.click("#tab-layers");
  await p.click("#layer-quality");
  await p.click("#layer-submaps");
});
await shot("plots", { dark: true }, async (p) => {
  await p.click("#tab-plots");
  await p.click("#play");
  await p.waitForTimeout(3000);
});
await shot("help", { dark: true }, async (p) => {
  await p.keyboard.press("?");
});
await shot("phone", { phone: true, dark: true });
await shot("phone-drawer", { phone: true, dark: false }, async (p) => {
  await p.click("#drawer");
  await p.waitForTimeout(300);
});
await browser.close();
await server.close();
