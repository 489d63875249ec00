/** The path near a place: each visit by its nearest node. */
import type { Point } from "../geometry.ts";
import type { Track } from "../track.ts";

export interface Visit {
  node: number;
  t: number;
  /** From the place [m]. */
  apart: number;
}

/** Nodes that far apart in the list are of two visits. */
const kGap = 8;
const kMostVisits = 24;

/** In the order of the path; those within `reach` metres of the place. */
export function visitsNear(track: Track, at: Point, reach: number): Visit[] {
  const visits: Visit[] = [];
  let last = -Infinity;
  for (let i = 0; i < track.length; i++) {
    const apart = Math.hypot(track.x(i) - at.x, track.y(i) - at.y);
    if (!(apart <= reach)) continue;
    const visit = { node: i, t: track.t[i] ?? 0, apart };
    const known = visits[visits.length - 1];
    if (known === undefined || i - last > kGap) visits.push(visit);
    else if (apart < known.apart) visits[visits.length - 1] = visit;
    last = i;
  }
  if (visits.length <= kMostVisits) return visits;
  const nearest = [...visits].sort((a, b) => a.apart - b.apart).slice(0, kMostVisits);
  return nearest.sort((a, b) => a.node - b.node);
}

/** The nearest of them; where there is another, not of the visit that `not` is of. */
export function nearestVisit(visits: Visit[], not: number | null): Visit | null {
  const others = not === null ? visits : visits.filter((one) => Math.abs(one.node - not) > kGap);
  const [first, ...rest] = others.length > 0 ? others : visits;
  if (first === undefined) return null;
  return rest.reduce((best, one) => (one.apart < best.apart ? one : best), first);
}

/** The node whose time is nearest; null on an empty path. */
export function nodeAt(track: Track, t: number): number | null {
  let found: number | null = null;
  let least = Infinity;
  for (let i = 0; i < track.length; i++) {
    const apart = Math.abs((track.t[i] ?? 0) - t);
    if (apart < least) [found, least] = [i, apart];
  }
  return found;
}
