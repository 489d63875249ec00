/** The page with a run made by code: npm run demo [-- --mode mapping] [-- --large] [-- --no-edit] [-- --port 8700] */
import { readFile } from "node:fs/promises";
import { parseArgs } from "node:util";
import { largeRun, officeRun } from "./run.ts";
import { DemoServer, type Options } from "./server.ts";

const { values } = parseArgs({
  options: {
    mode: { type: "string", default: "replay" },
    port: { type: "string", default: "8700" },
    large: { type: "boolean", default: false },
    "no-edit": { type: "boolean", default: false },
    token: { type: "string" },
    page: { type: "string", default: "built/index.html" },
  },
});

const modes = ["replay", "mapping", "localizing"] as const;
const mode = modes.find((one) => one === values.mode);
if (mode === undefined) throw new Error(`--mode ${values.mode}: one of ${modes.join(", ")}`);
const options: Options = {
  mode,
  page: await readFile(values.page),
  token: values.token ?? null,
  canSeek: mode !== "localizing",
  playing: true,
  edit: mode === "replay" && !values.large && !values["no-edit"],
};
const server = new DemoServer(values.large ? largeRun() : officeRun(), options);
await server.listen(Number(values.port));
console.log(`open ${server.url}`);
