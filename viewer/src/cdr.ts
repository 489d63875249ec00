/** CDR (XCDR1) as ROS 2 writes it: 4 bytes of encapsulation, then values aligned to their size. */

/** What a damaged message is refused with; whoever reads messages catches it. */
export class DamagedMessage extends Error {}

export class CdrReader {
  private readonly view: DataView;
  private readonly little: boolean;
  private at = 4;

  constructor(private readonly bytes: Uint8Array) {
    if (bytes.byteLength < 4) throw new DamagedMessage("shorter than its encapsulation");
    const kind = bytes[1] ?? 0xff;
    if (bytes[0] !== 0 || kind > 1) throw new DamagedMessage("an encapsulation other than CDR");
    this.little = kind === 1;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  }

  get left(): number {
    return this.bytes.byteLength - this.at;
  }

  u8(): number {
    return this.view.getUint8(this.take(1));
  }

  bool(): boolean {
    return this.u8() !== 0;
  }

  i32(): number {
    return this.view.getInt32(this.take(4), this.little);
  }

  u32(): number {
    return this.view.getUint32(this.take(4), this.little);
  }

  f32(): number {
    return this.view.getFloat32(this.take(4), this.little);
  }

  f64(): number {
    return this.view.getFloat64(this.take(8), this.little);
  }

  string(): string {
    const length = this.count(1);
    const start = this.take(length, 1);
    // The length counts the zero at the end; some writers leave both out when the text is empty.
    const end = length > 0 && this.bytes[start + length - 1] === 0 ? length - 1 : length;
    return new TextDecoder().decode(this.bytes.subarray(start, start + end));
  }

  /** How many elements follow; refused where the rest of the message cannot hold them. */
  count(bytesEach: number): number {
    const count = this.u32();
    if (count * bytesEach > this.left)
      throw new DamagedMessage("a sequence longer than the message");
    return count;
  }

  /** A view of the message's own bytes: valid as long as the message is. */
  u8s(): Uint8Array {
    const count = this.count(1);
    const start = this.take(count, 1);
    return this.bytes.subarray(start, start + count);
  }

  i32s(): Int32Array {
    return Int32Array.from(this.numbers(4, (at) => this.view.getInt32(at, this.little)));
  }

  u32s(): Uint32Array {
    return Uint32Array.from(this.numbers(4, (at) => this.view.getUint32(at, this.little)));
  }

  f32s(): Float32Array {
    const count = this.count(4);
    const start = this.take(4 * count, 4);
    const values = new Float32Array(count);
    for (let i = 0; i < count; i++) values[i] = this.view.getFloat32(start + 4 * i, this.little);
    return values;
  }

  f64s(): Float64Array {
    const count = this.count(8);
    const start = count > 0 ? this.take(8 * count, 8) : 0;
    const values = new Float64Array(count);
    for (let i = 0; i < count; i++) values[i] = this.view.getFloat64(start + 8 * i, this.little);
    return values;
  }

  private numbers(size: number, read: (at: number) => number): number[] {
    const count = this.count(size);
    const start = this.take(size * count, size);
    return Array.from({ length: count }, (_, i) => read(start + size * i));
  }

  /** Aligns, checks and steps over `length` bytes; where they begin. */
  private take(length: number, alignment = length): number {
    const start = this.at + ((alignment - ((this.at - 4) % alignment)) % alignment || 0);
    if (start + length > this.bytes.byteLength) throw new DamagedMessage("it ends too early");
    this.at = start + length;
    return start;
  }
}
