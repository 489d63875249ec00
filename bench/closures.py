"""Loop closures of a map, judged where the truth is known.

A closure is false when it is more than 0.3 m or 3 deg off the true relative pose, and by more than
its own covariance allows (chi2 of 16.3, one in a thousand): along a corridor a closure says
nothing, and its covariance says so. A revisit is a metre of the true path at most 1 m away from a
place left more than 20 m of travel before; it is recognised when a true, accepted closure ends in a
submap of the 8 m of travel before it.
"""
import bisect
import csv
import math

FALSE_M, FALSE_DEG = 0.3, 3.0
ALLOWED_CHI2 = 16.27
COVARIANCE = ["xx_m2", "xy_m2", "xyaw_m_rad", "yy_m2", "yyaw_m_rad", "yawyaw_rad2"]
NEAR_M, AWAY_M, SUBMAP_M = 1.0, 20.0, 8.0
PRECISION = 0.995  # of those that stand, what is asked for


class Truth:
    """The true path: pose and travel at any stamp."""

    def __init__(self, path):
        self.stamps, self.poses, self.travel = [], [], []
        for line in path.read_text().splitlines():
            if line.startswith("#"):
                continue
            t, x, y, _, _, _, qz, qw = map(float, line.split())
            step = math.dist((x, y), self.poses[-1][:2]) if self.poses else 0.0
            self.travel.append((self.travel[-1] if self.travel else 0.0) + step)
            self.stamps.append(t)
            self.poses.append((x, y, 2.0 * math.atan2(qz, qw)))

    def index(self, stamp):
        """Of the nearest pose: closures end at scans, each of which has one."""
        after = min(bisect.bisect_left(self.stamps, stamp), len(self.stamps) - 1)
        if after > 0 and stamp - self.stamps[after - 1] < self.stamps[after] - stamp:
            return after - 1
        return after

    def relative(self, first, second):
        (ax, ay, a), (bx, by, b) = self.poses[first], self.poses[second]
        c, s = math.cos(a), math.sin(a)
        return c * (bx - ax) + s * (by - ay), -s * (bx - ax) + c * (by - ay), b - a

    def revisits(self):
        """Travel at each metre of the path that comes back to a place."""
        found, cells, entered, next_m = [], {}, 0, 0.0
        for i, (x, y, _) in enumerate(self.poses):
            while self.travel[entered] < self.travel[i] - AWAY_M:
                ex, ey, _ = self.poses[entered]
                cells.setdefault((math.floor(ex / NEAR_M), math.floor(ey / NEAR_M)), []).append(
                    (ex, ey)
                )
                entered += 1
            if self.travel[i] < next_m:
                continue
            next_m = self.travel[i] + 1.0
            column, row = math.floor(x / NEAR_M), math.floor(y / NEAR_M)
            near = (
                place
                for dx in (-1, 0, 1)
                for dy in (-1, 0, 1)
                for place in cells.get((column + dx, row + dy), ())
            )
            if any(math.dist(place, (x, y)) <= NEAR_M for place in near):
                found.append(self.travel[i])
        return found


def chi2(error, covariance):
    """error^T P^-1 error for a 3x3 covariance given by its upper triangle: Cholesky by hand."""
    xx, xy, xt, yy, yt, tt = covariance
    a = math.sqrt(xx)
    b, c = xy / a, xt / a
    d = math.sqrt(yy - b * b)
    e = (yt - b * c) / d
    f = math.sqrt(tt - c * c - e * e)
    u = error[0] / a
    v = (error[1] - b * u) / d
    w = (error[2] - c * u - e * v) / f
    return u * u + v * v + w * w


def judge(folder, sim):
    """Counts of one run, and how far the worst false closure is off."""
    truth = Truth(sim / "truth.tum")
    counts = {"accepted": 0, "false": 0, "rejected": 0, "revoked": 0, "wrongly_rejected": 0}
    ends, false_m, false_deg = [], [0.0], [0.0]
    with open(folder / "loop_closures.csv", encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            first, second = truth.index(float(row["from_t_s"])), truth.index(float(row["to_t_s"]))
            x, y, yaw = truth.relative(first, second)
            off_m = math.hypot(x - float(row["x_m"]), y - float(row["y_m"]))
            off_rad = math.remainder(yaw - float(row["yaw_rad"]), 2.0 * math.pi)
            near = off_m <= FALSE_M and abs(math.degrees(off_rad)) <= FALSE_DEG
            error = (float(row["x_m"]) - x, float(row["y_m"]) - y, -off_rad)
            good = near or chi2(error, [float(row[name]) for name in COVARIANCE]) <= ALLOWED_CHI2
            if row["accepted"] == "1":
                counts["accepted"] += 1
                counts["false"] += 0 if good else 1
                if good:
                    ends.append(truth.travel[second])
                else:
                    false_m.append(off_m)
                    false_deg.append(abs(math.degrees(off_rad)))
            else:
                counts["rejected"] += 1
                counts["revoked"] += 1 if row["reason"].startswith("revoked") else 0
                counts["wrongly_rejected"] += 1 if good else 0
    ends.sort()
    revisits = truth.revisits()
    counts["revisits"] = len(revisits)
    counts["recognised"] = sum(
        1
        for travel in revisits
        if bisect.bisect_right(ends, travel) > bisect.bisect_left(ends, travel - SUBMAP_M)
    )
    return {**counts, "false_m": max(false_m), "false_deg": max(false_deg)}


def total(runs, key):
    return sum(run[key] for run in runs if not run.get("failed"))
