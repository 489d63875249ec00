/** Takes pictures of a page at a steady pace: node run.mjs demo/film.ts URL FOLDER COUNT SECONDS */
import { mkdir } from "node:fs/promises";
import { launch, open, until } from "../tests/support/browser.ts";

const [url = "", folder = "", count = "30", seconds = "1"] = process.argv.slice(2);
await mkdir(folder, { recursive: true });
const browser = await launch();
const how = { width: 900, height: 540, dark: true, reducedMotion: true };
const { page, faults } = await open(browser, url, how);
await until(page, (state) => state.nodes > 1 && state.robot !== null, "the run");
const begin = Date.now();
for (let i = 0; i < Number(count); i++) {
  // As it grows, all of the map is in sight.
  await page.keyboard.press("f");
  await page.waitForTimeout(Math.max(0, begin + i * Number(seconds) * 1000 - Date.now()));
  await page.screenshot({ path: `${folder}/${String(i).padStart(3, "0")}.png` });
}
await browser.close();
if (faults.length > 0) throw new Error(faults.join("\n"));
