/** Buffers of lines and marks: filled on the processor, each drawn at once. */
import type { Colour } from "../colours.ts";
import {
  kLineFragment,
  kLineVertex,
  kMarkFragment,
  kMarkVertex,
  link,
  type Program,
} from "./programs.ts";
import type { View } from "./view.ts";

/** Both triangles of a quad with four vertices. */
const kCorners = [0, 1, 2, 2, 1, 3];

/**
 * Records of floats and bytes, four times each: once for every corner of their quad. (Instances
 * would need a quarter of the room, but cost a processor that draws as much as a draw call each.)
 * The buffer grows by doubling and is used again.
 */
class Records {
  count = 0;
  floats: Float32Array;
  bytes: Uint8Array;
  private words: Uint32Array;
  private data: ArrayBuffer;

  /** `size` is that of one record, in bytes. */
  constructor(readonly size: number) {
    this.data = new ArrayBuffer(4 * size * 64);
    this.floats = new Float32Array(this.data);
    this.words = new Uint32Array(this.data);
    this.bytes = new Uint8Array(this.data);
  }

  /** Room for one more; where its floats begin. */
  next(): number {
    const begin = this.count * 4 * this.size;
    if (begin + 4 * this.size > this.data.byteLength) {
      const old = this.bytes;
      this.data = new ArrayBuffer(this.data.byteLength * 2);
      this.floats = new Float32Array(this.data);
      this.words = new Uint32Array(this.data);
      this.bytes = new Uint8Array(this.data);
      this.bytes.set(old);
    }
    return begin / 4;
  }

  /** The record at `begin` is written: its copies follow. */
  done(begin: number): void {
    const { words } = this;
    const length = this.size / 4;
    for (let i = 0; i < length; i++) {
      const word = words[begin + i] ?? 0;
      words[begin + length + i] = word;
      words[begin + 2 * length + i] = word;
      words[begin + 3 * length + i] = word;
    }
    this.count++;
  }

  used(): Uint8Array {
    return this.bytes.subarray(0, this.count * 4 * this.size);
  }
}

/** A buffer of the graphics card that grows by doubling. */
class Uploaded {
  private readonly buffer: WebGLBuffer | null;
  private capacity = 0;

  constructor(
    private readonly gl: WebGL2RenderingContext,
    private readonly target: number,
  ) {
    this.buffer = gl.createBuffer();
  }

  bind(): void {
    this.gl.bindBuffer(this.target, this.buffer);
  }

  write(bytes: ArrayBufferView): void {
    const { gl, target } = this;
    this.bind();
    if (bytes.byteLength > this.capacity) {
      this.capacity = Math.max(1024, 2 ** Math.ceil(Math.log2(bytes.byteLength)));
      gl.bufferData(target, this.capacity, gl.DYNAMIC_DRAW);
    }
    gl.bufferSubData(target, 0, bytes);
  }
}

export const enum Pattern {
  Solid,
  Dotted,
  Dashed,
  DashDot,
  Joined,
}

export const enum Shape {
  Disc,
  Ring,
  Cross,
  Diamond,
  Arrow,
}

function byteOf(share: number): number {
  return Math.round(Math.min(1, Math.max(0, share)) * 255);
}

/** What all batches of a context share: programs, and the indices of quads. */
export class Shapes {
  readonly line: Program;
  readonly mark: Program;
  private readonly indices: Uploaded;
  private quads = 0;

  constructor(readonly gl: WebGL2RenderingContext) {
    this.line = link(gl, kLineVertex, kLineFragment);
    this.mark = link(gl, kMarkVertex, kMarkFragment);
    this.indices = new Uploaded(gl, gl.ELEMENT_ARRAY_BUFFER);
  }

  drawQuads(count: number): void {
    const { gl } = this;
    if (count > this.quads) {
      this.quads = Math.max(256, 2 ** Math.ceil(Math.log2(count)));
      const indices = new Uint32Array(6 * this.quads);
      for (let i = 0; i < indices.length; i++) {
        indices[i] = 4 * Math.floor(i / 6) + (kCorners[i % 6] ?? 0);
      }
      this.indices.write(indices);
    } else {
      this.indices.bind();
    }
    gl.drawElements(gl.TRIANGLES, 6 * count, gl.UNSIGNED_INT, 0);
  }
}

abstract class Batch {
  private readonly uploaded: Uploaded;
  private stale = true;

  constructor(
    protected readonly shapes: Shapes,
    protected readonly records: Records,
  ) {
    this.uploaded = new Uploaded(shapes.gl, shapes.gl.ARRAY_BUFFER);
  }

  get count(): number {
    return this.records.count;
  }

  clear(): void {
    this.records.count = 0;
    this.stale = true;
  }

  /** Sets the attributes, each given by its size, type and place in the record. */
  protected drawWith(
    attributes: [size: number, bytes: "floats" | "share" | "bytes", at: number][],
  ) {
    const { gl } = this.shapes;
    if (this.stale) this.uploaded.write(this.records.used());
    else this.uploaded.bind();
    this.stale = false;
    attributes.forEach(([size, kind, at], index) => {
      const type = kind === "floats" ? gl.FLOAT : gl.UNSIGNED_BYTE;
      gl.enableVertexAttribArray(index);
      gl.vertexAttribPointer(index, size, type, kind === "share", this.records.size, at);
    });
    for (let index = attributes.length; index < 5; index++) gl.disableVertexAttribArray(index);
    this.shapes.drawQuads(this.count);
  }
}

/** Lines: begin, end, a colour at each, a width and a pattern. */
export class Lines extends Batch {
  constructor(shapes: Shapes) {
    super(shapes, new Records(28));
  }

  /** Colours in bytes; the width in pixels. */
  addShaded(
    ax: number,
    ay: number,
    bx: number,
    by: number,
    from: Colour,
    to: Colour,
    alpha: number,
    width: number,
    pattern: Pattern,
  ): void {
    const at = this.records.next();
    const { floats, bytes } = this.records;
    floats[at] = ax;
    floats[at + 1] = ay;
    floats[at + 2] = bx;
    floats[at + 3] = by;
    for (let k = 0; k < 3; k++) {
      bytes[4 * at + 16 + k] = from[k] ?? 0;
      bytes[4 * at + 20 + k] = to[k] ?? 0;
    }
    bytes[4 * at + 19] = bytes[4 * at + 23] = byteOf(alpha);
    bytes[4 * at + 24] = Math.min(255, Math.round(width * 2));
    bytes[4 * at + 25] = pattern;
    this.records.done(at);
  }

  /** In one colour, 0..1. */
  add(
    ax: number,
    ay: number,
    bx: number,
    by: number,
    colour: Colour,
    alpha: number,
    width: number,
    pattern: Pattern,
  ): void {
    const bytes = [byteOf(colour[0]), byteOf(colour[1]), byteOf(colour[2])] as const;
    this.addShaded(ax, ay, bx, by, bytes, bytes, alpha, width, pattern);
  }

  draw(view: View): void {
    if (this.count === 0) return;
    view.use(this.shapes.line);
    this.drawWith([
      [2, "floats", 0],
      [2, "floats", 8],
      [4, "share", 16],
      [4, "share", 20],
      [2, "bytes", 24],
    ]);
  }
}

/** Marks of one place, colour, size and shape each. */
export class Marks extends Batch {
  constructor(shapes: Shapes) {
    super(shapes, new Records(20));
  }

  add(
    x: number,
    y: number,
    yaw: number,
    colour: Colour,
    alpha: number,
    size: number,
    shape: Shape,
  ): void {
    const at = this.records.next();
    const { floats, bytes } = this.records;
    floats[at] = x;
    floats[at + 1] = y;
    floats[at + 2] = yaw;
    for (let k = 0; k < 3; k++) bytes[4 * at + 12 + k] = byteOf(colour[k] ?? 0);
    bytes[4 * at + 15] = byteOf(alpha);
    bytes[4 * at + 16] = Math.min(255, Math.round(size * 2));
    bytes[4 * at + 17] = shape;
    this.records.done(at);
  }

  draw(view: View): void {
    if (this.count === 0) return;
    const { gl, mark } = this.shapes;
    view.use(mark);
    gl.uniform1f(mark.at("angle"), view.camera.angle);
    this.drawWith([
      [3, "floats", 0],
      [4, "share", 12],
      [2, "bytes", 16],
    ]);
  }
}
