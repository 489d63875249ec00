"""How wrong a map is at its worst place: its trajectory against the truth, best aligned; and how
wrong it says that it may be."""

import bisect
import csv
import math

# A map is right that is off by no more than this anywhere, best aligned.
RIGHT_M, RIGHT_DEG = 0.5, 1.0
# A map states by its covariances how far off it may be: so many standard deviations.
SIGMAS = 3.0
# A scan by itself may be off without the map being so; half of some seconds may not.
SECONDS = 5.0
# While the robot turns, the time that a sweep takes turns every pose of a laser whose log does not
# tell it; the map is none the worse.
STILL_RAD_S = 0.05


def read_tum(path):
    """[(stamp, x, y, yaw)]"""
    poses = []
    for line in open(path, encoding="utf-8"):
        if line.startswith("#") or not line.strip():
            continue
        v = [float(word) for word in line.split()]
        poses.append((v[0], v[1], v[2], 2.0 * math.atan2(v[6], v[7])))
    return poses


def wrap(angle):
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def pairs_of(estimate, truth, within_s=0.05):
    stamps = [pose[0] for pose in truth]
    pairs = []
    for pose in estimate:
        at = bisect.bisect_left(stamps, pose[0])
        near = [i for i in (at - 1, at) if 0 <= i < len(stamps)]
        best = min(near, key=lambda i: abs(stamps[i] - pose[0]))
        if abs(stamps[best] - pose[0]) < within_s:
            pairs.append((pose, best))
    return pairs


def turn_rates(truth):
    """Of each pose, over the second around it [rad/s]."""
    rates = []
    first = last = 0
    turned = [0.0]
    for a, b in zip(truth, truth[1:]):
        turned.append(turned[-1] + abs(wrap(b[3] - a[3])))
    for pose in truth:
        while truth[first][0] < pose[0] - 0.5:
            first += 1
        while last + 1 < len(truth) and truth[last + 1][0] <= pose[0] + 0.5:
            last += 1
        seconds = truth[last][0] - truth[first][0]
        rates.append((turned[last] - turned[first]) / seconds if seconds > 0.0 else 0.0)
    return rates


def running_median(stamps, values):
    """The largest of the medians of all windows of SECONDS; of fewer seconds, that of all."""
    if not values or stamps[-1] - stamps[0] < SECONDS:
        return abs(sorted(values)[len(values) // 2]) if values else 0.0
    window = []
    first = 0
    largest = 0.0
    for i, value in enumerate(values):
        bisect.insort(window, value)
        while stamps[i] - stamps[first] > SECONDS:
            window.pop(bisect.bisect_left(window, values[first]))
            first += 1
        # Where the robot turns the heading is left out: a window holds some that is not.
        if stamps[i] - stamps[first] > 0.5 * SECONDS:
            largest = max(largest, abs(window[len(window) // 2]))
    return largest


def largest_error(estimate_path, truth_path):
    """(metres, degrees) after the best alignment: the largest of the running medians; of the
    heading, while the robot does not turn."""
    truth = read_tum(truth_path)
    pairs = pairs_of(read_tum(estimate_path), truth)
    n = len(pairs)
    mean = [sum(pose[k] for pose, _ in pairs) / n for k in (1, 2)]
    goal = [sum(truth[i][k] for _, i in pairs) / n for k in (1, 2)]
    dot = cross = 0.0
    for pose, i in pairs:
        x, y = pose[1] - mean[0], pose[2] - mean[1]
        u, v = truth[i][1] - goal[0], truth[i][2] - goal[1]
        dot += x * u + y * v
        cross += x * v - y * u
    turn = math.atan2(cross, dot)
    c, s = math.cos(turn), math.sin(turn)
    rates = turn_rates(truth)
    stamps, off_m, still, off_rad = [], [], [], []
    for pose, i in pairs:
        x, y = pose[1] - mean[0], pose[2] - mean[1]
        off = math.hypot(
            goal[0] + c * x - s * y - truth[i][1], goal[1] + s * x + c * y - truth[i][2]
        )
        stamps.append(pose[0])
        off_m.append(off)
        if rates[i] < STILL_RAD_S:
            still.append(pose[0])
            off_rad.append(wrap(pose[3] + turn - truth[i][3]))
    return running_median(stamps, off_m), math.degrees(running_median(still, off_rad))


def stated_error(covariances_path):
    """(metres, degrees): SIGMAS times the largest standard deviation of a position, along its
    longest axis, and of a heading, by a map's trajectory.csv."""
    largest_m2 = largest_rad2 = 0.0
    with open(covariances_path, encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            xx, xy, yy = (float(row[name]) for name in ("xx_m2", "xy_m2", "yy_m2"))
            longest = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)
            largest_m2 = max(largest_m2, longest)
            largest_rad2 = max(largest_rad2, float(row["yawyaw_rad2"]))
    return SIGMAS * math.sqrt(largest_m2), math.degrees(SIGMAS * math.sqrt(largest_rad2))


def is_right(worst_m, worst_deg):
    return worst_m <= RIGHT_M and worst_deg <= RIGHT_DEG


def is_foretold(worst, stated):
    """Whether all by which a map is wrong, (metres, degrees), is within what it states itself."""
    return all(
        off <= max(right, most) for off, right, most in zip(worst, (RIGHT_M, RIGHT_DEG), stated)
    )
