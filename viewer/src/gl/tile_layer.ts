import { type Box, emptyBox, include, overlap, type Pose } from "../geometry.ts";
import type { MapTiles, OccupancyGrid } from "../messages.ts";
import type { MapSink } from "../model.ts";
import { blockOf, extentOf, halved, halvings, stored } from "./cells.ts";
import { kCellsFragment, kQuadVertex, link, type Program } from "./programs.ts";
import type { View } from "./view.ts";

const kBlockCells = 1024;
const kMostBlocks = 1024;

interface Block {
  texture: WebGLTexture;
  column: number;
  row: number;
}

/** The map: tiles lie in blocks, each a texture of one byte a cell with its smaller copies. */
export class TileLayer implements MapSink {
  readonly box: Box = emptyBox();
  tiles = new Set<string>();
  full = false;
  resolution = 0;
  /** Grows with whatever changes the picture. */
  version = 0;
  private size = 0;
  private tilesABlock = 1;
  private levels = 1;
  private origin: Pose = { x: 0, y: 0, yaw: 0 };
  private readonly blocks = new Map<string, Block>();
  private scratch: Uint8Array[] = [];
  private readonly program: Program;

  constructor(private readonly gl: WebGL2RenderingContext) {
    this.program = link(gl, kQuadVertex, kCellsFragment);
  }

  get blockCount(): number {
    return this.blocks.size;
  }

  addTiles(given: MapTiles): void {
    if (given.whole || given.size !== this.size || given.resolution !== this.resolution) {
      this.begin(given.size, given.resolution, { x: 0, y: 0, yaw: 0 });
    }
    const cells = given.size * given.size;
    for (let i = 0; 2 * i < given.ids.length; i++) {
      const column = given.ids[2 * i] ?? 0;
      const row = given.ids[2 * i + 1] ?? 0;
      this.put(column, row, given.cells.subarray(i * cells, (i + 1) * cells));
    }
    this.version++;
  }

  /** A grid in one piece is cut into tiles, in a frame of its own. */
  setGrid(grid: OccupancyGrid): void {
    const size = 256;
    this.begin(size, grid.resolution, grid.origin);
    const tile = new Uint8Array(size * size);
    for (let row = 0; row * size < grid.height; row++) {
      for (let column = 0; column * size < grid.width; column++) {
        tile.fill(255);
        const length = Math.min(size, grid.width - column * size);
        for (let y = 0; y < Math.min(size, grid.height - row * size); y++) {
          const at = (row * size + y) * grid.width + column * size;
          tile.set(grid.cells.subarray(at, at + length), y * size);
        }
        this.put(column, row, tile);
      }
    }
    this.version++;
  }

  clear(): void {
    for (const block of this.blocks.values()) this.gl.deleteTexture(block.texture);
    this.blocks.clear();
    this.tiles.clear();
    this.size = this.resolution = 0;
    this.full = false;
    Object.assign(this.box, emptyBox());
    this.version++;
  }

  private begin(size: number, resolution: number, origin: Pose): void {
    this.clear();
    this.size = size;
    this.resolution = resolution;
    this.origin = origin;
    this.tilesABlock = Math.max(1, Math.floor(kBlockCells / size));
    this.levels = 1 + halvings(size);
    this.scratch = Array.from({ length: this.levels }, (_, l) => new Uint8Array((size >> l) ** 2));
  }

  private put(column: number, row: number, cells: Uint8Array): void {
    const { gl, size, levels, scratch } = this;
    const across = blockOf(column, this.tilesABlock);
    const up = blockOf(row, this.tilesABlock);
    const block = this.blockAt(across.block, up.block);
    if (block === null) {
      this.full = true;
      return;
    }
    stored(cells, scratch[0] ?? new Uint8Array(0));
    gl.bindTexture(gl.TEXTURE_2D, block.texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    for (let level = 0; level < levels; level++) {
      const from = scratch[level - 1];
      const own = scratch[level];
      if (own === undefined) break;
      const side = size >> level;
      if (from !== undefined) halved(from, size >> (level - 1), own);
      const x = across.within * side;
      const y = up.within * side;
      gl.texSubImage2D(gl.TEXTURE_2D, level, x, y, side, side, gl.RED, gl.UNSIGNED_BYTE, own);
    }
    this.tiles.add(`${column},${row}`);
    this.includeTile(column, row);
  }

  /** Of a tile only what is known, to eight cells. */
  private includeTile(column: number, row: number): void {
    const level = Math.min(3, this.levels - 1);
    const within = extentOf(this.scratch[level] ?? new Uint8Array(0), this.size >> level);
    if (within === null) return;
    const texel = this.resolution * 2 ** level;
    const side = this.size * this.resolution;
    const c = Math.cos(this.origin.yaw);
    const s = Math.sin(this.origin.yaw);
    for (const x of [column * side + within.left * texel, column * side + within.right * texel]) {
      for (const y of [row * side + within.bottom * texel, row * side + within.top * texel]) {
        include(this.box, this.origin.x + c * x - s * y, this.origin.y + s * x + c * y);
      }
    }
  }

  private blockAt(column: number, row: number): Block | null {
    const key = `${column},${row}`;
    const known = this.blocks.get(key);
    if (known !== undefined) return known;
    if (this.blocks.size >= kMostBlocks) return null;
    const { gl } = this;
    const texture = gl.createTexture();
    if (texture === null) return null;
    gl.bindTexture(gl.TEXTURE_2D, texture);
    // A fresh texture is all zeros: unknown.
    const side = this.size * this.tilesABlock;
    gl.texStorage2D(gl.TEXTURE_2D, this.levels, gl.R8, side, side);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST_MIPMAP_NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    const block = { texture, column, row };
    this.blocks.set(key, block);
    return block;
  }

  draw(view: View, opacity: number): void {
    if (this.blocks.size === 0) return;
    const { gl, program } = this;
    const side = this.size * this.tilesABlock * this.resolution;
    const c = Math.cos(this.origin.yaw);
    const s = Math.sin(this.origin.yaw);
    const cellPixels = this.resolution * view.camera.scale * view.pixelRatio;
    // The finest level whose texels are not smaller than a pixel.
    const wish = Math.ceil(Math.log2(1 / cellPixels) - 0.01);
    const lod = Math.min(this.levels - 1, Math.max(0, wish));
    view.use(program);
    gl.uniform1i(program.at("lod"), lod);
    gl.uniform1f(program.at("texelPixels"), cellPixels * 2 ** lod);
    gl.uniform3fv(program.at("freeColour"), view.palette.free);
    gl.uniform3fv(program.at("occupiedColour"), view.palette.occupied);
    gl.uniform1f(program.at("opacity"), opacity);
    gl.uniform2f(program.at("extent"), side, side);
    for (const block of this.blocks.values()) {
      const own = { x: block.column * side, y: block.row * side };
      const x = this.origin.x + c * own.x - s * own.y;
      const y = this.origin.y + s * own.x + c * own.y;
      const reach = this.origin.yaw === 0 ? 0 : side;
      const box = {
        left: x - reach,
        bottom: y - reach,
        right: x + side + reach,
        top: y + side + reach,
      };
      if (!overlap(box, view.seen)) continue;
      gl.uniform4f(program.at("origin"), x, y, c, s);
      gl.bindTexture(gl.TEXTURE_2D, block.texture);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    }
  }
}
