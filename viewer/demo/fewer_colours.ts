/** A PNG with at most 256 colours, which for pictures of pages is a third of the bytes. */
import { deflateSync } from "node:zlib";
import { chunk, type Image, kSignature } from "./png.ts";

const kBits = 4;

/** The most frequent colours, after rounding where there are more than fit; others go to the nearest. */
function paletteOf(image: Image): number[] {
  const counts = new Map<number, number>();
  for (let i = 0; i < image.data.length; i += 4) {
    const [r = 0, g = 0, b = 0] = image.data.subarray(i, i + 3);
    const colour = (r << 16) | (g << 8) | b;
    counts.set(colour, (counts.get(colour) ?? 0) + 1);
  }
  const byCount = [...counts].sort((a, b) => b[1] - a[1]).map(([colour]) => colour);
  // Half for what there is most of, half for one of each kind of the rest.
  const palette = byCount.slice(0, 128);
  const kinds = new Set<number>();
  for (const colour of byCount.slice(128)) {
    const kind = [16, 8, 0].reduce(
      (key, shift) => key * 16 + (((colour >> shift) & 255) >> (8 - kBits)),
      0,
    );
    if (kinds.has(kind) || palette.length >= 256) continue;
    kinds.add(kind);
    palette.push(colour);
  }
  return palette;
}

function nearest(palette: number[], colour: number): number {
  let found = 0;
  let least = Infinity;
  palette.forEach((other, i) => {
    const apart = [16, 8, 0].reduce(
      (sum, shift) => sum + (((colour >> shift) & 255) - ((other >> shift) & 255)) ** 2,
      0,
    );
    if (apart < least) [found, least] = [i, apart];
  });
  return found;
}

export function fewerColours(image: Image): Buffer {
  const palette = paletteOf(image);
  const known = new Map<number, number>();
  const rows = Buffer.alloc(image.height * (1 + image.width));
  for (let y = 0; y < image.height; y++) {
    for (let x = 0; x < image.width; x++) {
      const at = 4 * (y * image.width + x);
      const [r = 0, g = 0, b = 0] = image.data.subarray(at, at + 3);
      const colour = (r << 16) | (g << 8) | b;
      let index = known.get(colour);
      if (index === undefined) known.set(colour, (index = nearest(palette, colour)));
      rows[y * (1 + image.width) + 1 + x] = index;
    }
  }
  const header = Buffer.alloc(13);
  header.writeUInt32BE(image.width, 0);
  header.writeUInt32BE(image.height, 4);
  header.set([8, 3, 0, 0, 0], 8);
  const colours = Buffer.from(
    palette.flatMap((colour) => [colour >> 16, (colour >> 8) & 255, colour & 255]),
  );
  return Buffer.concat([
    kSignature,
    chunk("IHDR", header),
    chunk("PLTE", colours),
    chunk("IDAT", deflateSync(rows, { level: 9 })),
    chunk("IEND", Buffer.alloc(0)),
  ]);
}
