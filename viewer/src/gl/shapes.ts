/** Buffers of lines and marks: filled on the processor, drawn as instances. */
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

/** Records of floats and bytes in one buffer that grows by doubling and is used again. */
class Records {
  count = 0;
  floats: Float32Array;
  bytes: Uint8Array;
  private data: ArrayBuffer;

  constructor(readonly size: number) {
    this.data = new ArrayBuffer(size * 256);
    this.floats = new Float32Array(this.data);
    this.bytes = new Uint8Array(this.data);
  }

  /** Room for one more; where its floats begin. */
  next(): number {
    if ((this.count + 1) * this.size > this.data.byteLength) {
      const old = this.bytes;
      this.data = new ArrayBuffer(this.data.byteLength * 2);
      this.floats = new Float32Array(this.data);
      this.bytes = new Uint8Array(this.data);
      this.bytes.set(old);
    }
    return (this.count++ * this.size) / 4;
  }

  used(): Uint8Array {
    return this.bytes.subarray(0, this.count * this.size);
  }
}

/** One buffer of the graphics card, written anew only when its records have changed. */
class Uploaded {
  private readonly buffer: WebGLBuffer | null;
  private capacity = 0;

  constructor(private readonly gl: WebGL2RenderingContext) {
    this.buffer = gl.createBuffer();
  }

  bind(): void {
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, this.buffer);
  }

  write(bytes: Uint8Array): void {
    const { gl } = this;
    this.bind();
    if (bytes.byteLength > this.capacity) {
      this.capacity = Math.max(1024, 2 ** Math.ceil(Math.log2(bytes.byteLength)));
      gl.bufferData(gl.ARRAY_BUFFER, this.capacity, gl.DYNAMIC_DRAW);
    }
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, bytes);
  }
}

function attribute(
  gl: WebGL2RenderingContext,
  index: number,
  size: number,
  type: number,
  normalized: boolean,
  stride: number,
  offset: number,
): void {
  gl.enableVertexAttribArray(index);
  gl.vertexAttribPointer(index, size, type, normalized, stride, offset);
  gl.vertexAttribDivisor(index, 1);
}

export const enum Pattern {
  Solid,
  Dotted,
  Dashed,
  DashDot,
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

/** Programs that all batches of a context share. */
export class ShapePrograms {
  readonly line: Program;
  readonly mark: Program;

  constructor(gl: WebGL2RenderingContext) {
    this.line = link(gl, kLineVertex, kLineFragment);
    this.mark = link(gl, kMarkVertex, kMarkFragment);
  }
}

abstract class Batch {
  protected readonly uploaded: Uploaded;
  private stale = true;

  constructor(
    protected readonly gl: WebGL2RenderingContext,
    protected readonly records: Records,
  ) {
    this.uploaded = new Uploaded(gl);
  }

  get count(): number {
    return this.records.count;
  }

  clear(): void {
    this.records.count = 0;
    this.stale = true;
  }

  protected refresh(): void {
    if (this.stale) this.uploaded.write(this.records.used());
    else this.uploaded.bind();
    this.stale = false;
  }
}

/** Lines that stand alone: begin, end, one colour, a width and a pattern each. */
export class Lines extends Batch {
  constructor(gl: WebGL2RenderingContext) {
    super(gl, new Records(24));
  }

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
    const at = this.records.next();
    const { floats, bytes } = this.records;
    floats[at] = ax;
    floats[at + 1] = ay;
    floats[at + 2] = bx;
    floats[at + 3] = by;
    for (let k = 0; k < 3; k++) bytes[4 * at + 16 + k] = byteOf(colour[k] ?? 0);
    bytes[4 * at + 19] = byteOf(alpha);
    bytes[4 * at + 20] = Math.min(255, Math.round(width * 2));
    bytes[4 * at + 21] = pattern;
  }

  draw(view: View, program: Program): void {
    if (this.count === 0) return;
    const { gl } = this;
    view.use(program);
    this.refresh();
    attribute(gl, 0, 2, gl.FLOAT, false, 24, 0);
    attribute(gl, 1, 2, gl.FLOAT, false, 24, 8);
    attribute(gl, 2, 4, gl.UNSIGNED_BYTE, true, 24, 16);
    attribute(gl, 3, 4, gl.UNSIGNED_BYTE, true, 24, 16);
    attribute(gl, 4, 2, gl.UNSIGNED_BYTE, false, 24, 20);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.count);
  }
}

/** A line through nodes; each has a colour, and says whether it is joined to the one before. */
export class Polyline extends Batch {
  constructor(gl: WebGL2RenderingContext) {
    super(gl, new Records(12));
  }

  add(x: number, y: number, red: number, green: number, blue: number, joined: boolean): void {
    const at = this.records.next();
    const { floats, bytes } = this.records;
    floats[at] = x;
    floats[at + 1] = y;
    bytes[4 * at + 8] = red;
    bytes[4 * at + 9] = green;
    bytes[4 * at + 10] = blue;
    bytes[4 * at + 11] = joined ? 255 : 0;
  }

  draw(view: View, program: Program, width: number): void {
    if (this.count < 2) return;
    const { gl } = this;
    view.use(program);
    this.refresh();
    attribute(gl, 0, 2, gl.FLOAT, false, 12, 0);
    attribute(gl, 1, 2, gl.FLOAT, false, 12, 12);
    attribute(gl, 2, 4, gl.UNSIGNED_BYTE, true, 12, 8);
    attribute(gl, 3, 4, gl.UNSIGNED_BYTE, true, 12, 20);
    gl.disableVertexAttribArray(4);
    gl.vertexAttrib2f(4, width * 2, Pattern.Solid);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.count - 1);
  }
}

/** Marks of one place, colour, size and shape each. */
export class Marks extends Batch {
  constructor(gl: WebGL2RenderingContext) {
    super(gl, new Records(20));
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
  }

  draw(view: View, program: Program): void {
    if (this.count === 0) return;
    const { gl } = this;
    view.use(program);
    gl.uniform1f(program.at("angle"), view.camera.angle);
    this.refresh();
    attribute(gl, 0, 3, gl.FLOAT, false, 20, 0);
    attribute(gl, 1, 4, gl.UNSIGNED_BYTE, true, 20, 12);
    attribute(gl, 2, 2, gl.UNSIGNED_BYTE, false, 20, 16);
    gl.disableVertexAttribArray(3);
    gl.disableVertexAttribArray(4);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.count);
  }
}
