#!/usr/bin/env node
// Bundles TypeScript and runs it: node run.mjs FILE.ts [ARGUMENT...]
//                                 node run.mjs --test FILE.ts... (node's own test runner)
import { spawn } from "node:child_process";
import { basename } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const folder = fileURLToPath(new URL(".", import.meta.url));
const testing = process.argv[2] === "--test";
const entries = testing ? process.argv.slice(3) : process.argv.slice(2, 3);
if (entries.length === 0) throw new Error("which file?");
const out = `${folder}node_modules/.built`;
await build({
  absWorkingDir: folder,
  entryPoints: entries,
  outdir: out,
  outbase: ".",
  entryNames: "[name]",
  outExtension: { ".js": ".mjs" },
  bundle: true,
  packages: "external",
  platform: "node",
  format: "esm",
  target: "node18",
  sourcemap: "inline",
  logLevel: "warning",
});
const files = entries.map((entry) => `${out}/${basename(entry).replace(/\.ts$/, ".mjs")}`);
const words = testing
  ? ["--test", "--test-reporter=spec", ...files]
  : [...files, ...process.argv.slice(3)];
const child = spawn(process.execPath, ["--enable-source-maps", ...words], {
  cwd: folder,
  stdio: "inherit",
});
for (const signal of ["SIGINT", "SIGTERM"]) process.on(signal, () => child.kill(signal));
child.on("exit", (code, signal) => process.exit(code ?? (signal === null ? 1 : 130)));
