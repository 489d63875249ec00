/**
 * A figure over time in bounded memory. Values fall into buckets that keep the least and the
 * largest; when there are too many, neighbours are joined, so no peak is ever lost.
 */
export class Series {
  readonly begin: Float64Array;
  readonly end: Float64Array;
  readonly low: Float32Array;
  readonly high: Float32Array;
  readonly last: Float32Array;
  length = 0;
  /** Values that go into one bucket before the next is begun. */
  private perBucket = 1;
  private inLast = 0;

  constructor(readonly capacity = 2048) {
    if (capacity < 2 || capacity % 2 !== 0) throw new RangeError("an even capacity of at least 2");
    this.begin = new Float64Array(capacity);
    this.end = new Float64Array(capacity);
    this.low = new Float32Array(capacity);
    this.high = new Float32Array(capacity);
    this.last = new Float32Array(capacity);
  }

  /** Time that goes back takes with it what came later. */
  add(t: number, value: number): void {
    if (!Number.isFinite(t) || !Number.isFinite(value)) return;
    this.forgetFrom(t);
    if (this.length > 0 && this.inLast < this.perBucket) {
      this.joinInto(this.length - 1, t, value);
      return;
    }
    if (this.length === this.capacity) this.halve();
    const i = this.length++;
    this.begin[i] = this.end[i] = t;
    this.low[i] = this.high[i] = this.last[i] = value;
    this.inLast = 1;
  }

  clear(): void {
    this.length = 0;
    this.perBucket = 1;
    this.inLast = 0;
  }

  /** The bucket whose time is nearest to t; -1 without any. */
  nearest(t: number): number {
    if (this.length === 0) return -1;
    let below = 0;
    let above = this.length - 1;
    while (below < above) {
      const middle = (below + above) >> 1;
      if (this.at(this.end, middle) < t) below = middle + 1;
      else above = middle;
    }
    const before = below - 1;
    if (before < 0 || this.at(this.begin, below) <= t) return below;
    return t - this.at(this.end, before) < this.at(this.begin, below) - t ? before : below;
  }

  private at(values: Float64Array | Float32Array, i: number): number {
    return values[i] ?? 0;
  }

  private forgetFrom(t: number): void {
    if (this.length === 0 || this.at(this.end, this.length - 1) < t) return;
    while (this.length > 0 && this.at(this.begin, this.length - 1) >= t) {
      this.length--;
      this.inLast = this.perBucket;
    }
    if (this.length === 0) this.clear();
    else if (this.at(this.end, this.length - 1) > t) this.end[this.length - 1] = t;
  }

  private joinInto(i: number, t: number, value: number): void {
    this.end[i] = t;
    this.low[i] = Math.min(this.at(this.low, i), value);
    this.high[i] = Math.max(this.at(this.high, i), value);
    this.last[i] = value;
    this.inLast++;
  }

  private halve(): void {
    const half = this.length / 2;
    for (let i = 0; i < half; i++) {
      const a = 2 * i;
      this.begin[i] = this.at(this.begin, a);
      this.end[i] = this.at(this.end, a + 1);
      this.low[i] = Math.min(this.at(this.low, a), this.at(this.low, a + 1));
      this.high[i] = Math.max(this.at(this.high, a), this.at(this.high, a + 1));
      this.last[i] = this.at(this.last, a + 1);
    }
    this.perBucket *= 2;
    this.length = half;
  }
}
