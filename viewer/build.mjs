#!/usr/bin/env node
// Bundles viewer/src into one page without outside requests.
//
//     node build.mjs            writes built/index.html
//     node build.mjs --check    fails where built/index.html is not what the sources give
import { createHash } from "node:crypto";
import { readFile, writeFile } from "node:fs/promises";
import { build, transform } from "esbuild";

const kMostBytes = 200_000;
const folder = new URL(".", import.meta.url);
const target = new URL("built/index.html", folder);

const read = (path) => readFile(new URL(path, folder), "utf8");
const hashOf = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

async function page() {
  const bundle = await build({
    absWorkingDir: new URL(".", folder).pathname,
    entryPoints: ["src/main.ts"],
    bundle: true,
    format: "iife",
    target: "es2022",
    minify: true,
    charset: "utf8",
    legalComments: "none",
    write: false,
    logLevel: "warning",
  });
  const script = bundle.outputFiles[0].text.replaceAll("</script", "<\\/script").trim();
  const css = await transform(await read("src/style.css"), { loader: "css", minify: true });
  const style = css.code.trim();
  // Nothing but the page's own script and style, and nobody but the page's own server.
  const policy = [
    "default-src 'none'",
    `script-src ${hashOf(script)}`,
    `style-src ${hashOf(style)}`,
    "img-src data: blob:",
    "connect-src 'self' ws: wss:",
    "base-uri 'none'",
    "form-action 'none'",
  ].join("; ");
  const filled = { POLICY: policy, STYLE: style, SCRIPT: script };
  const template = (await read("src/index.html")).replace(/>\s*\n\s*</g, ">\n<");
  return template.replace(/\s*%(POLICY|STYLE|SCRIPT)%\s*/g, (_, name) => filled[name]);
}

const text = await page();
const size = Buffer.byteLength(text);
if (size > kMostBytes) throw new Error(`the page has ${size} bytes, more than ${kMostBytes}`);
if (process.argv.includes("--check")) {
  const built = await readFile(target, "utf8").catch(() => "");
  if (built !== text) {
    console.error("viewer/built/index.html is not what viewer/src gives: scripts/build_viewer.sh");
    process.exit(1);
  }
  console.log(`viewer/built/index.html is current, ${size} bytes`);
} else {
  await writeFile(target, text);
  console.log(`viewer/built/index.html, ${size} bytes`);
}
