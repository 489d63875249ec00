/** Writes CDR as ROS 2 does; the page's reader is tested against it. */
export class CdrWriter {
  private bytes = new Uint8Array(256);
  private view = new DataView(this.bytes.buffer);
  private at = 4;

  constructor(private readonly little = true) {
    this.bytes[1] = little ? 1 : 0;
  }

  private room(size: number, alignment: number): number {
    const start = this.at + ((alignment - ((this.at - 4) % alignment)) % alignment);
    if (start + size > this.bytes.length) {
      const grown = new Uint8Array(Math.max(2 * this.bytes.length, start + size));
      grown.set(this.bytes);
      this.bytes = grown;
      this.view = new DataView(grown.buffer);
    }
    this.at = start + size;
    return start;
  }

  u8(value: number): this {
    this.view.setUint8(this.room(1, 1), value);
    return this;
  }

  i32(value: number): this {
    const at = this.room(4, 4);
    this.view.setInt32(at, value, this.little);
    return this;
  }

  u32(value: number): this {
    const at = this.room(4, 4);
    this.view.setUint32(at, value, this.little);
    return this;
  }

  f32(...values: number[]): this {
    for (const value of values) {
      const at = this.room(4, 4);
      this.view.setFloat32(at, value, this.little);
    }
    return this;
  }

  f64(...values: number[]): this {
    for (const value of values) {
      const at = this.room(8, 8);
      this.view.setFloat64(at, value, this.little);
    }
    return this;
  }

  string(text: string): this {
    const bytes = new TextEncoder().encode(text);
    this.u32(bytes.length + 1);
    const at = this.room(bytes.length + 1, 1);
    this.bytes.set(bytes, at);
    this.bytes[at + bytes.length] = 0;
    return this;
  }

  u8s(values: Uint8Array): this {
    this.u32(values.length);
    const at = this.room(values.length, 1);
    this.bytes.set(values, at);
    return this;
  }

  i32s(values: ArrayLike<number>): this {
    this.u32(values.length);
    for (const value of Array.from(values)) this.i32(value);
    return this;
  }

  u32s(values: ArrayLike<number>): this {
    this.u32(values.length);
    for (const value of Array.from(values)) this.u32(value);
    return this;
  }

  f32s(values: ArrayLike<number>): this {
    return this.u32(values.length).each(values, (value) => this.f32(value));
  }

  f64s(values: ArrayLike<number>): this {
    return this.u32(values.length).each(values, (value) => this.f64(value));
  }

  private each(values: ArrayLike<number>, write: (value: number) => void): this {
    for (let i = 0; i < values.length; i++) write(values[i] ?? 0);
    return this;
  }

  stamp(seconds: number): this {
    const whole = Math.floor(seconds);
    return this.i32(whole).u32(Math.round((seconds - whole) * 1e9));
  }

  header(seconds: number, frame: string): this {
    return this.stamp(seconds).string(frame);
  }

  pose(x: number, y: number, yaw: number): this {
    return this.f64(x, y, 0, 0, 0, Math.sin(yaw / 2), Math.cos(yaw / 2));
  }

  done(): Uint8Array {
    return this.bytes.slice(0, this.at);
  }
}
