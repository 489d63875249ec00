// Looks at the documentation site in Chromium, on a desk and on a telephone: no page is wider than
// the window, nothing fails or is loaded from elsewhere, and the search finds what there is. Ends
// with 77, and says why, where there is no browser (scripts/install_viewer.sh).
//
//     node tests/site/check_in_browser.mjs [build/site/html]
import { existsSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join, normalize, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const root = resolve(process.argv[2] ?? "build/site/html");
const viewer = fileURLToPath(new URL("../../viewer", import.meta.url));
const playwright = join(viewer, "node_modules/playwright-core/index.mjs");
const chromium = [
  "/usr/bin/chromium",
  "/usr/bin/chromium-browser",
  "/usr/bin/google-chrome",
].find(existsSync);
if (!existsSync(playwright) || chromium === undefined) {
  console.log(
    "skipped: no Chromium or no modules of Node (scripts/install_viewer.sh)",
  );
  process.exit(77);
}
const kTypes = {
  ".html": "text/html",
  ".css": "text/css",
  ".js": "text/javascript",
  ".json": "application/json",
};
const kPages = [
  "index.html",
  "student.html",
  "owner.html",
  "developer.html",
  "fleet.html",
];
kPages.push(
  "command_line.html",
  "accuracy.html",
  "api/slam.html",
  "python.html",
  "python_api/index.html",
  "python_api/mapping.html",
  "python_api/options_simulation.html",
  "live_view.html",
  "notebooks/01_first_map.html",
  "notebooks/05_localization.html",
);

const server = createServer(async (request, response) => {
  const path = normalize(
    decodeURIComponent(new URL(request.url, "http://x").pathname),
  );
  try {
    const body = await readFile(join(root, path));
    response.writeHead(200, {
      "content-type": kTypes[extname(path)] ?? "application/octet-stream",
    });
    response.end(body);
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const site = `http://127.0.0.1:${server.address().port}/`;

const { chromium: browserType } = await import(playwright);
const browser = await browserType.launch({
  executablePath: chromium,
  args: ["--no-sandbox"],
});
const problems = [];
for (const [name, width, height] of [
  ["desk", 1280, 900],
  ["telephone", 390, 800],
]) {
  const page = await browser.newPage({ viewport: { width, height } });
  let at = "";
  page.on("pageerror", (error) =>
    problems.push(`${name} ${at}: ${error.message}`),
  );
  page.on("request", (request) => {
    if (!request.url().startsWith(site) && !/^(data|blob):/.test(request.url()))
      problems.push(`${name} ${at}: asks for ${request.url()}`);
  });
  page.on("response", (response) => {
    if (response.status() >= 400)
      problems.push(
        `${name} ${at}: ${response.status()} for ${response.url()}`,
      );
  });
  for (at of kPages) {
    await page.goto(site + at, { waitUntil: "load" });
    const wide = await page.evaluate(
      () => document.documentElement.scrollWidth,
    );
    if (wide > width) problems.push(`${name} ${at}: ${wide} pixels wide`);
    const small = await page.evaluate(() =>
      parseFloat(
        getComputedStyle(document.querySelector(".md-typeset p")).fontSize,
      ),
    );
    if (small < 12) problems.push(`${name} ${at}: text of ${small} pixels`);
  }
  at = "search";
  await page.goto(`${site}index.html`, { waitUntil: "load" });
  if (name === "telephone")
    await page.click("label[for=__search].md-header__button");
  await page.fill("input[name=query]", "branch and bound");
  try {
    await page.waitForSelector(".md-search-result__item a", {
      timeout: 30_000,
    });
  } catch {
    problems.push(`${name}: the search finds nothing`);
  }
  await page.close();
}
await browser.close();
server.close();
for (const problem of problems) console.log(problem);
console.log(
  `${kPages.length} pages on a desk and a telephone, ${problems.length} problems`,
);
process.exit(problems.length > 0 ? 1 : 0);
