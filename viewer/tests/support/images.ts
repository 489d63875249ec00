/** Pictures compared by the share of pixels that differ clearly. */
import { existsSync } from "node:fs";
import { mkdir, readFile, writeFile } from "node:fs/promises";
import { decodePng, encodePng, type Image } from "../../demo/png.ts";

/** Of a channel, from 0 to 255: what smoothing of edges and fonts may change. */
const kClear = 48;

export function differingShare(a: Image, b: Image): number {
  if (a.width !== b.width || a.height !== b.height) return 1;
  let differing = 0;
  for (let i = 0; i < a.data.length; i += 4) {
    let most = 0;
    for (let k = 0; k < 3; k++)
      most = Math.max(most, Math.abs((a.data[i + k] ?? 0) - (b.data[i + k] ?? 0)));
    if (most > kClear) differing++;
  }
  return differing / (a.width * a.height);
}

/** Pixels that are about of a colour. */
export function countOf(
  image: Image,
  [red, green, blue]: [number, number, number],
  within = 24,
): number {
  let count = 0;
  for (let i = 0; i < image.data.length; i += 4) {
    const [r = 0, g = 0, b = 0] = image.data.subarray(i, i + 3);
    if (
      Math.abs(r - red) <= within &&
      Math.abs(g - green) <= within &&
      Math.abs(b - blue) <= within
    )
      count++;
  }
  return count;
}

/** Half as wide and high, by means of four: what is stored. */
export function halfOf(image: Image): Image {
  const width = image.width >> 1;
  const height = image.height >> 1;
  const data = new Uint8Array(4 * width * height);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      for (let k = 0; k < 4; k++) {
        const at = (dx: number, dy: number) =>
          image.data[4 * ((2 * y + dy) * image.width + 2 * x + dx) + k] ?? 0;
        data[4 * (y * width + x) + k] = (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1) + 2) >> 2;
      }
    }
  }
  return { width, height, data };
}

/**
 * The share of pixels in which a picture differs from the stored one of its name; stores it with
 * UPDATE_PICTURES=1. Both are left in build/viewer where they differ too much.
 */
export async function differenceFromStored(name: string, png: Buffer): Promise<number> {
  const stored = `tests/pictures/${name}.png`;
  const now = halfOf(decodePng(png));
  if (process.env["UPDATE_PICTURES"] === "1" || !existsSync(stored)) {
    if (process.env["UPDATE_PICTURES"] !== "1")
      throw new Error(`${stored} is missing: UPDATE_PICTURES=1`);
    await mkdir("tests/pictures", { recursive: true });
    await writeFile(stored, encodePng(now));
    return 0;
  }
  const share = differingShare(decodePng(await readFile(stored)), now);
  if (share > 0.002) {
    await mkdir("../build/viewer", { recursive: true });
    await writeFile(`../build/viewer/${name}.png`, encodePng(now));
  }
  return share;
}
