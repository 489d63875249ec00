"""Plans of simulated worlds against what stands in them. Needs shapely.

What is true is taken from the world itself (measure_plan_truth): walls are the union of its walls'
boxes. A room is what they enclose once every gap of a door's width between two of them in one line
is closed; its door is that gap."""
import json
import math
import pathlib

import map_cells
import numpy as np
import shapely
from program import run
from shapely.geometry import LineString, MultiPoint, Point, Polygon, box
from shapely.ops import unary_union
from shapely.strtree import STRtree

NEAR_M = 0.02  # of a true wall: the target's limit
FAR_M = 0.05  # a line farther from every wall is of something else
SEEN_M = 0.05  # a wall was seen where the map has an occupied cell this near
STEP_M = 0.05
DOOR_M = (0.55, 1.4)


def rotated(x, y, yaw, corners):
    c, s = math.cos(yaw), math.sin(yaw)
    return [(x + c * u - s * v, y + s * u + c * v) for u, v in corners]


def polygon_of(x, y, yaw, length, width):
    half_l, half_w = 0.5 * length, 0.5 * width
    corners = [(-half_l, -half_w), (half_l, -half_w), (half_l, half_w), (-half_l, half_w)]
    return Polygon(rotated(x, y, yaw, corners))


def door_gaps(walls):
    """Gaps between two walls in one line, as (polygon, width, middle)."""
    gaps = []
    for i, (xa, ya, yaw, la, wa) in enumerate(walls):
        for k, (xb, yb, yaw_b, lb, wb) in enumerate(walls):
            if i == k or abs(wa - wb) > 0.01 or abs(math.sin(yaw - yaw_b)) > 0.001:
                continue
            dx, dy = xb - xa, yb - ya
            along = math.cos(yaw) * dx + math.sin(yaw) * dy
            across = -math.sin(yaw) * dx + math.cos(yaw) * dy
            width = along - 0.5 * (la + lb)
            if along <= 0 or abs(across) > 0.01 or not DOOR_M[0] <= width <= 3.2:
                continue
            at = 0.5 * la + 0.5 * width
            middle = xa + math.cos(yaw) * at, ya + math.sin(yaw) * at
            gaps.append((polygon_of(*middle, yaw, width + 0.002, wa), width, middle))
    return gaps


class Truth:
    def __init__(self, program, world, seed):
        data = json.loads(run([program, world, seed])[0])
        walls = [b[:5] for b in data["boxes"] if b[5]]
        self.walls = unary_union([polygon_of(*b).buffer(1e-4) for b in walls])
        things = [polygon_of(*b[:5]) for b in data["boxes"] if not b[5]]
        self.things = unary_union(things + [Point(x, y).buffer(r) for x, y, r in data["circles"]])
        solid = self.walls
        gaps = [g for g in door_gaps(walls) if not solid.intersects(g[0].buffer(-0.02))]
        self.doors = [(width, middle) for _, width, middle in gaps if width <= DOOR_M[1]]
        closed = unary_union([self.walls] + [g[0].buffer(1e-3) for g in gaps])
        self.rooms = []
        for part in getattr(closed, "geoms", [closed]):
            self.rooms += [Polygon(hole) for hole in part.interiors]
        # A room that walls stand in, or other rooms, has them as holes.
        parts = list(getattr(closed, "geoms", [closed]))
        self.rooms = [
            room.difference(unary_union([p for p in parts if room.contains(p)] or [Polygon()]))
            for room in self.rooms
        ]
        self.rooms = [room for room in self.rooms if room.area >= 2.0]


def aligned(estimate, reference):
    """The motion that puts the estimated path onto the true one, as x, y, yaw (Umeyama 1991)."""

    ours, true = (np.loadtxt(path, usecols=(0, 1, 2)) for path in (estimate, reference))
    known = (ours[:, 0] >= true[0, 0]) & (ours[:, 0] <= true[-1, 0])
    a = ours[known, 1:]
    b = np.stack([np.interp(ours[known, 0], true[:, 0], true[:, k]) for k in (1, 2)], axis=1)
    ma, mb = a.mean(0), b.mean(0)
    h = (a - ma).T @ (b - mb)
    yaw = math.atan2(h[0, 1] - h[1, 0], h[0, 0] + h[1, 1])
    c, s = math.cos(yaw), math.sin(yaw)
    return mb[0] - c * ma[0] + s * ma[1], mb[1] - s * ma[0] - c * ma[1], yaw


class Mover:
    def __init__(self, motion):
        self.x, self.y, self.yaw = motion

    def __call__(self, points):
        return rotated(self.x, self.y, self.yaw, points)


def features(path, anchor):
    """A plan's GeoJSON, back in metres of the map: anchors near the equator are nearly flat."""
    radius_east, radius_north = 6378137.0, 6335439.327  # WGS 84 on the equator
    found = {"room": [], "door": [], "opening": [], "structure": [], "hidden": [], "movable": []}

    def metres(position):
        return (
            math.radians(position[0] - anchor[1]) * radius_east,
            math.radians(position[1] - anchor[0]) * radius_north,
        )

    for feature in json.loads(pathlib.Path(path).read_text())["features"]:
        shape = feature["geometry"]["coordinates"]
        rings = shape if feature["geometry"]["type"] == "Polygon" else [shape]
        found[feature["properties"]["layer"]].append(
            ([[metres(p) for p in ring] for ring in rings], feature["properties"])
        )
    return found


def sampled(line, step=STEP_M):
    count = max(1, round(line.length / step))
    return [line.interpolate((i + 0.5) / count, normalized=True) for i in range(count)], (
        line.length / count
    )


def wall_figures(truth, plan, move, map_folder):
    """Shares of lengths [m]."""
    cells = map_cells.cells_of(map_folder)
    occupied = []
    for index, state in enumerate(cells.states):
        if state == map_cells.OCCUPIED:
            row, column = divmod(index, cells.width)
            occupied.append(
                (
                    cells.x_m + (column + 0.5) * cells.resolution_m,
                    cells.y_m + (row + 0.5) * cells.resolution_m,
                )
            )
    seen_cells = STRtree([Point(p) for p in move(occupied)])
    lines = {
        layer: [(LineString(move(rings[0])), about) for rings, about in plan[layer]]
        for layer in ("structure", "hidden", "movable")
    }
    walls = STRtree([line for line, _ in lines["structure"]])
    all_lines = [line for layer in lines.values() for line, _ in layer]
    anything = STRtree(all_lines)
    seen = near = near_any = 0.0
    border = truth.walls.boundary
    for ring in getattr(border, "geoms", [border]):
        points, weight = sampled(ring)
        for point in points:
            if not len(seen_cells.query(point, predicate="dwithin", distance=SEEN_M)):
                continue
            seen += weight
            near += weight * bool(len(walls.query(point, predicate="dwithin", distance=NEAR_M)))
            near_any += weight * bool(
                len(anything.query(point, predicate="dwithin", distance=NEAR_M))
            )
    drawn = far = 0.0
    zs = []
    for line, about in lines["structure"]:
        points, weight = sampled(line)
        off = [border.distance(p) for p in points]
        drawn += line.length
        far += weight * sum(d > FAR_M for d in off)
        if line.length >= 0.5 and max(off) < FAR_M:
            zs.append(
                border.distance(line.interpolate(0.5, normalized=True)) / about["sigma_across_m"]
            )
    return {
        "seen_m": seen,
        "within": near / seen,
        "within_any": near_any / seen,
        "drawn_m": drawn,
        "extra_m": far,
        "z_rms": math.sqrt(sum(min(z, 10.0) ** 2 for z in zs) / max(1, len(zs))),
        "hidden_m": sum(line.length for line, _ in lines["hidden"]),
    }


def room_figures(truth, plan, move):
    rows = []
    for rings, about in plan["room"]:
        polygon = Polygon(move(rings[0]), [move(ring) for ring in rings[1:]]).buffer(0)
        best = max(truth.rooms, key=lambda room: room.intersection(polygon).area, default=None)
        common = best.intersection(polygon).area if best else 0.0
        match = common / best.union(polygon).area if best else 0.0
        rows.append(
            {
                "area_m2": about["area_m2"],
                "sigma_m2": about["area_sigma_m2"],
                "true_m2": best.area if best else None,
                "overlap": match,
                "closed": about["closed"],
                "hidden_m": about["hidden_m"],
                "simple": polygon.is_valid,
            }
        )
    return rows


def door_figures(truth, plan, move):
    found = [
        (np.mean(move(rings[0]), axis=0), about["width_m"], about["width_sigma_m"])
        for rings, about in plan["door"]
    ]
    area = unary_union(
        [Polygon(move(rings[0])).buffer(0.3) for rings, _ in plan["room"]] or [Polygon()]
    )
    errors, missed = [], 0
    taken = set()
    for width, middle in truth.doors:
        if not area.contains(Point(middle)):
            continue
        near = [(math.dist(at, middle), i) for i, (at, _, _) in enumerate(found) if i not in taken]
        distance, i = min(near, default=(1.0, -1))
        if distance > 0.25:
            missed += 1
            continue
        taken.add(i)
        errors.append(found[i][1] - width)
    return {
        "found": len(errors),
        "missed": missed,
        "false": len(found) - len(taken),
        "width_rms_m": math.sqrt(sum(e * e for e in errors) / max(1, len(errors))),
    }
