import type { Pose } from "./geometry.ts";
import type { Trajectory } from "./messages.ts";

/** The path of all nodes, in arrays that grow by doubling and are kept. */
export class Track {
  length = 0;
  t = new Float64Array(1024);
  poses = new Float32Array(3 * 1024);
  sigma = new Float32Array(1024);
  submaps = new Uint32Array(1024);
  drives = new Uint32Array(1024);

  /** False where nodes are missing between those that are known and those that are given. */
  replace(given: Trajectory): boolean {
    if (given.first > this.length) return false;
    this.reserve(given.count);
    this.t.set(given.t, given.first);
    this.poses.set(given.poses, 3 * given.first);
    this.sigma.set(given.sigma, given.first);
    this.submaps.set(given.submaps, given.first);
    this.drives.set(given.drives, given.first);
    this.length = given.count;
    return true;
  }

  clear(): void {
    this.length = 0;
  }

  pose(i: number): Pose | null {
    if (!(i >= 0 && i < this.length)) return null;
    const [x = 0, y = 0, yaw = 0] = this.poses.subarray(3 * i, 3 * i + 3);
    return { x, y, yaw };
  }

  x(i: number): number {
    return this.poses[3 * i] ?? 0;
  }

  y(i: number): number {
    return this.poses[3 * i + 1] ?? 0;
  }

  /** Time of the next node after t, or of the last before it; null where there is none. */
  neighbour(t: number, step: 1 | -1): number | null {
    const margin = 1e-6;
    let found: number | null = null;
    // Several drives need not be in the order of their clocks, so every node is asked.
    for (let i = 0; i < this.length; i++) {
      const time = this.t[i] ?? 0;
      if ((time - t) * step <= margin) continue;
      if (found === null || (found - time) * step > 0) found = time;
    }
    return found;
  }

  private reserve(count: number): void {
    let capacity = this.t.length;
    if (count <= capacity) return;
    while (capacity < count) capacity *= 2;
    const grown = <T extends { set(from: T): void }>(from: T, to: T): T => {
      to.set(from);
      return to;
    };
    this.t = grown(this.t, new Float64Array(capacity));
    this.poses = grown(this.poses, new Float32Array(3 * capacity));
    this.sigma = grown(this.sigma, new Float32Array(capacity));
    this.submaps = grown(this.submaps, new Uint32Array(capacity));
    this.drives = grown(this.drives, new Uint32Array(capacity));
  }
}
