/** Lines with fewer nodes that look the same. */

/**
 * Indices of the nodes that a line needs so that no other lies farther from it than `tolerance`.
 *
 * From a node that is kept, each one skipped leaves a cone of directions that pass it closely
 * enough; the line goes on while the next node lies in all of them (Williams 1978). Nodes are kept
 * at least every `longest`, and wherever `breaks` says so, on both sides of the break.
 */
export function neededNodes(
  count: number,
  x: (i: number) => number,
  y: (i: number) => number,
  tolerance: number,
  longest: number,
  breaks: (i: number) => boolean,
): number[] {
  const kept: number[] = [];
  if (count === 0) return kept;
  let anchor = 0;
  let low = -Infinity;
  let high = Infinity;
  let axis = 0;
  let farthest = 0;
  const begin = (i: number) => {
    kept.push(i);
    anchor = i;
    low = -Infinity;
    high = Infinity;
    farthest = 0;
  };
  begin(0);
  for (let i = 1; i < count; i++) {
    if (breaks(i)) {
      if (anchor !== i - 1) kept.push(i - 1);
      begin(i);
      continue;
    }
    let dx = x(i) - x(anchor);
    let dy = y(i) - y(anchor);
    let length = Math.hypot(dx, dy);
    // A line that turns back on itself must be kept as far as it went.
    const back = length < farthest - tolerance;
    if (low !== -Infinity && (back || length > longest || outside(dx, dy, axis, low, high))) {
      begin(i - 1);
      dx = x(i) - x(anchor);
      dy = y(i) - y(anchor);
      length = Math.hypot(dx, dy);
    }
    farthest = Math.max(farthest, length);
    if (length <= tolerance) continue;
    const direction = Math.atan2(dy, dx);
    if (low === -Infinity) {
      axis = direction;
      low = -Math.PI / 2;
      high = Math.PI / 2;
    }
    const spread = Math.asin(Math.min(1, tolerance / length));
    const apart = turned(direction - axis);
    low = Math.max(low, apart - spread);
    high = Math.min(high, apart + spread);
  }
  if (anchor !== count - 1) kept.push(count - 1);
  return kept;
}

function turned(angle: number): number {
  return Math.atan2(Math.sin(angle), Math.cos(angle));
}

function outside(dx: number, dy: number, axis: number, low: number, high: number): boolean {
  const apart = turned(Math.atan2(dy, dx) - axis);
  return apart < low || apart > high;
}
