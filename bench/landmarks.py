#!/usr/bin/env python3
"""Follows simulated robots by reflectors alone, from nowhere, and holds their poses against the
truth: by how many landmarks a reading shows, and by drive. Then maps reflectors whose places are
not told, holds them against the truth, and follows another drive by them. Writes three tables of
docs/localization.md.

  bench/landmarks.py                     everything (about ten minutes, most of it simulation)
  bench/landmarks.py --only office       some cases
  bench/landmarks.py --only mapped-office mapped-hall     and so on: maps of landmarks alone
  bench/landmarks.py --quick             one seed, short drives; to look at, writes nothing
"""
import collections
import csv
import json
import math
import pathlib
import random
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from doc_blocks import table, write_block  # noqa: E402
from program import Loopstone, run  # noqa: E402
from provenance import provenance  # noqa: E402
from sections import measure_sections, section_parser  # noqa: E402

PAGE = ROOT / "docs/localization.md"
# Case: world, reflectors, and what makes it less kind.
CASES = {
    "office": ("office", 150, []),
    "warehouse": ("warehouse", 150, []),
    "hall": ("hall", 150, ["--max-range", "60"]),
    "few": ("office", 40, []),
    "usual": ("office", 150, ["--realism", "usual"]),
    "mount": ("office", 150, ["--realism", "mount"]),
    "people": ("office", 150, ["--people", "10"]),
    "carried": ("office", 150, ["--realism", "carried"]),
}
TITLES = {
    "office": "office, 150 reflectors",
    "warehouse": "warehouse, 150 reflectors",
    "hall": "hall of 100 m x 80 m, 150 reflectors, laser of 60 m",
    "few": "office, 40 reflectors",
    "usual": "office, 150 reflectors, the usual effects of realism",
    "mount": "office, 150 reflectors, the laser elsewhere than the robot's file says",
    "people": "office, 150 reflectors, ten people",
    "carried": "office, 150 reflectors, carried elsewhere unseen",
}
# Of those whose reflectors are mapped, too. MRCLAM's drives are made here: see mrclam_folder().
MAPPED = {f"mapped-{name}": name for name in ("office", "warehouse", "hall", "usual")}
MRCLAM = {"mapped-mrclam": [], "mapped-nameless": ["--nameless"]}
MRCLAM_TITLES = {
    "mapped-mrclam": "MRCLAM's kind, 15 barcodes, ranges of 150 mm, no scans",
    "mapped-nameless": "the same without names",
}
SEEDS = range(1, 4)
DURATION_S = 120
MOST_IN_VIEW = 5  # and more
APART_M = 0.5  # landmarks stand 1 m apart
RIGHT_M, RIGHT_RAD = 0.2, math.radians(5.0)


def truth_of(path):
    """Poses by their stamps in nanoseconds."""
    poses = {}
    for line in pathlib.Path(path).read_text().splitlines():
        t, x, y, _, _, _, qz, qw = line.split()
        poses[t] = (float(x), float(y), 2.0 * math.atan2(float(qz), float(qw)))
    return poses


def solved(matrix, vector):
    """matrix^-1 vector, by elimination; the matrix is positive definite."""
    rows = [list(row) + [value] for row, value in zip(matrix, vector)]
    size = len(rows)
    for i in range(size):
        for j in range(i + 1, size):
            factor = rows[j][i] / rows[i][i]
            rows[j] = [a - factor * b for a, b in zip(rows[j], rows[i])]
    result = [0.0] * size
    for i in reversed(range(size)):
        rest = sum(rows[i][j] * result[j] for j in range(i + 1, size))
        result[i] = (rows[i][size] - rest) / rows[i][i]
    return result


def errors_of(folder, where):
    """Of each pose: landmarks in view, error [m], of heading [rad], squared error by its
    covariance, state."""
    truth = truth_of(folder / "truth.tum")
    errors = []
    with open(where, encoding="utf-8") as file:
        for row in csv.DictReader(file):
            x, y, yaw = truth[row["t_s"]]
            off = [
                float(row["x_m"]) - x,
                float(row["y_m"]) - y,
                math.remainder(float(row["yaw_rad"]) - yaw, 2.0 * math.pi),
            ]
            xx, xy, xt, yy, yt, tt = (
                float(row[key])
                for key in ("xx_m2", "xy_m2", "xyaw_m_rad", "yy_m2", "yyaw_m_rad", "yawyaw_rad2")
            )
            by_covariance = solved([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]], off)
            errors.append(
                [
                    int(row["landmarks"]),
                    math.hypot(off[0], off[1]),
                    abs(off[2]),
                    sum(a * b for a, b in zip(off, by_covariance)),
                    row["state"],
                ]
            )
    return errors


def measure(name, loopstone, quick):
    world, reflectors, flags = CASES[name]
    runs = []
    for seed in list(SEEDS)[: 1 if quick else None]:
        folder = loopstone.simulate(
            world,
            seed,
            [
                *("--format", "mcap", "--reflectors", str(reflectors)),
                *("--duration", str(30 if quick else DURATION_S)),
                *flags,
            ],
        )
        where = loopstone.work / "landmarks.tum"
        output, cost = run(
            [
                *(loopstone.program, "localize", folder / "log.mcap", "--landmarks"),
                *(folder / "landmarks.csv", "-o", where, "--global", "--json", "--quiet"),
                "--force",
            ]
        )
        summary = json.loads(output)
        runs.append(
            {
                "seed": seed,
                "errors": errors_of(folder, where.with_suffix(".csv")),
                **{
                    key: summary[key]
                    for key in (
                        *("scans", "tracking_share", "lost_share", "first_tracking_s"),
                        *("first_tracking_m", "duration_s", "searches"),
                    )
                },
                "wall_s": cost["wall_s"],
            }
        )
    return runs


def best_motion(source, target):
    """Turn and shift (cos, sin, x, y) that lays points onto others, by least squares."""
    count = len(source)
    sx, sy = (sum(p[i] for p in source) / count for i in (0, 1))
    tx, ty = (sum(p[i] for p in target) / count for i in (0, 1))
    along = across = 0.0
    for (px, py), (qx, qy) in zip(source, target):
        ax, ay, bx, by = px - sx, py - sy, qx - tx, qy - ty
        along += ax * bx + ay * by
        across += ax * by - ay * bx
    size = math.hypot(along, across)
    c, s = along / size, across / size
    return c, s, tx - (c * sx - s * sy), ty - (s * sx + c * sy)


def moved(motion, point):
    c, s, x, y = motion
    return c * point[0] - s * point[1] + x, s * point[0] + c * point[1] + y


def places_of(path):
    with open(path, encoding="utf-8") as file:
        return [(float(row["x_m"]), float(row["y_m"])) for row in csv.DictReader(file)]


def landmark_errors(found, true, start):
    """Distances of the landmarks found from the true ones, after the best motion of all; how many
    lie where none is, or where another one lies already; and that motion.
    start:  a motion of the path onto the true one, to pair them by"""
    motion = start
    for _ in range(3):
        pairs, others, taken = [], 0, set()
        for point in found:
            at = moved(motion, point)
            distance, index = min((math.dist(at, q), i) for i, q in enumerate(true))
            if distance > APART_M or index in taken:
                others += 1
            else:
                taken.add(index)
                pairs.append((point, true[index]))
        motion = best_motion(*zip(*pairs))
    return [math.dist(moved(motion, p), q) for p, q in pairs], others, motion


def path_motion(estimate, truth):
    known = truth_of(truth) if not str(truth).endswith(".dat") else mrclam_truth(truth)
    pairs = []
    for line in pathlib.Path(estimate).read_text(encoding="utf-8").splitlines():
        t, x, y = line.split()[:3]
        at = known.get(t) or known.get(f"{float(t):.3f}")
        if at:
            pairs.append(((float(x), float(y)), at[:2]))
    return best_motion(*zip(*pairs))


def mrclam_truth(path):
    lines = pathlib.Path(path).read_text(encoding="utf-8").splitlines()
    return {t: (float(x), float(y)) for t, x, y, _ in map(str.split, lines)}


def errors_after_motion(folder, where, motion):
    """Of the poses of another drive: landmarks in view, error [m] after the motion, state."""
    truth = truth_of(folder / "truth.tum")
    errors = []
    with open(where.with_suffix(".csv"), encoding="utf-8") as file:
        for row in csv.DictReader(file):
            at = moved(motion, (float(row["x_m"]), float(row["y_m"])))
            off = math.dist(at, truth[row["t_s"]][:2])
            errors.append([int(row["landmarks"]), off, row["state"]])
    return errors


def mapped_run(loopstone, log, flags=()):
    out = loopstone.work / "landmark_map"
    output, cost = run(
        [
            *(loopstone.program, "map", log, "-o", out, "--landmarks", "--json", "--quiet"),
            *flags,
            "--force",
        ]
    )
    return out, json.loads(output), cost


def measure_mapped(name, loopstone, quick):
    world, reflectors, flags = CASES[MAPPED[name]]
    runs = []
    for seed in list(SEEDS)[: 1 if quick else None]:
        arguments = [
            *("--format", "mcap", "--reflectors", str(reflectors)),
            *("--duration", str(30 if quick else DURATION_S)),
            *flags,
        ]
        folder = loopstone.simulate(world, seed, arguments)
        out, summary, cost = mapped_run(loopstone, folder / "log.mcap")
        start = path_motion(out / "trajectory.tum", folder / "truth.tum")
        errors, others, motion = landmark_errors(
            places_of(out / "landmarks.csv"), places_of(folder / "landmarks.csv"), start
        )
        again = loopstone.simulate(world, seed, [*arguments, "--drive-seed", str(seed + 100)])
        where = loopstone.work / "again.tum"
        run(
            [
                *(loopstone.program, "localize", again / "log.mcap", "--landmarks", out, "-o"),
                *(where, "--global", "--quiet", "--force"),
            ]
        )
        runs.append(
            {
                "seed": seed,
                "errors": errors,
                "others": others,
                "again": errors_after_motion(again, where, motion),
                "duration_s": summary["duration_s"],
                "wall_s": cost["wall_s"],
            }
        )
    return runs


def mrclam_folder(folder, seed, duration_s):
    """A drive as UTIAS MRCLAM has them: a camera of 70 deg that reads barcodes up to 5 m, a
    hundredth of them wrong, two hundredths of the ranges too; odometry at 50 Hz."""
    folder.mkdir(parents=True, exist_ok=True)
    places, rng = random.Random(7), random.Random(seed)
    landmarks = []
    while len(landmarks) < 15:
        point = (places.uniform(-7.0, 7.0), places.uniform(-4.0, 4.0))
        if all(math.dist(point, other) > 1.2 for other in landmarks):
            landmarks.append(point)
    x = y = yaw = time_s = seen_s = 0.0
    goal, step_s = (4.0, 2.0), 0.02
    bias, scale = rng.gauss(0.0, 0.005), 1.0 + rng.gauss(0.0, 0.02)
    odometry, measurement, truth = [], [], []
    while time_s < duration_s:
        if math.dist(goal, (x, y)) < 0.5:
            goal = (rng.uniform(-5.5, 5.5), rng.uniform(-2.8, 2.8))
        ahead = math.remainder(math.atan2(goal[1] - y, goal[0] - x) - yaw, 2.0 * math.pi)
        rate = max(-0.5, min(0.5, 1.5 * ahead))
        speed = 0.25 * max(0.1, math.cos(ahead))
        stamp = f"{1000.0 + time_s:.3f}"
        told = speed * scale + rng.gauss(0.0, 0.02), rate + bias + rng.gauss(0.0, 0.03)
        odometry.append(f"{stamp} {told[0]:.4f} {told[1]:.4f}")
        truth.append(f"{stamp} {x:.5f} {y:.5f} {math.remainder(yaw, 2.0 * math.pi):.5f}")
        if time_s >= seen_s:
            seen_s = time_s + 0.2
            for i, point in enumerate(landmarks):
                way = math.dist(point, (x, y))
                bearing = math.atan2(point[1] - y, point[0] - x) - yaw
                bearing = math.remainder(bearing, 2.0 * math.pi)
                if way > 5.0 or abs(bearing) > math.radians(35.0) or rng.random() > 0.7:
                    continue
                who = rng.randrange(15) if rng.random() < 0.01 else i
                if rng.random() < 0.02:
                    way = rng.uniform(0.5, 5.0)
                way, bearing = way + rng.gauss(0.0, 0.15), bearing + rng.gauss(0.0, 0.04)
                measurement.append(f"{stamp} {10 * (who + 6)} {max(0.1, way):.4f} {bearing:.4f}")
        x += speed * math.cos(yaw) * step_s
        y += speed * math.sin(yaw) * step_s
        yaw += rate * step_s
        time_s += step_s
    barcodes = [f"{subject} {10 * subject}" for subject in range(1, 21)]
    for name, lines in (
        ("Barcodes.dat", barcodes),
        ("Robot1_Odometry.dat", odometry),
        ("Robot1_Measurement.dat", measurement),
        ("Robot1_Groundtruth.dat", truth),
    ):
        (folder / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return landmarks


def measure_mrclam(name, loopstone, quick):
    runs = []
    for seed in list(SEEDS)[: 1 if quick else None]:
        folder = loopstone.work / f"mrclam-{seed}"
        true = mrclam_folder(folder, seed, 120.0 if quick else 600.0)
        out, summary, cost = mapped_run(loopstone, folder, MRCLAM[name])
        start = path_motion(out / "trajectory.tum", folder / "Robot1_Groundtruth.dat")
        errors, others, _ = landmark_errors(places_of(out / "landmarks.csv"), true, start)
        runs.append(
            {
                **{"seed": seed, "errors": errors, "others": others, "again": []},
                "duration_s": summary["duration_s"],
                "wall_s": cost["wall_s"],
            }
        )
    return runs


def mapped_table(sections):
    rows = []
    for name, section in sections.items():
        runs = section["figures"]
        errors = [error for one in runs for error in one["errors"]]
        again = [error for one in runs for error in one["again"]]
        near = [off for seen, off, state in again if seen >= 5 and state == "TRACKING"]
        tracking = sum(state == "TRACKING" for _, _, state in again)
        pace = sum(one["duration_s"] for one in runs) / sum(one["wall_s"] for one in runs)
        rows.append(
            [
                TITLES[MAPPED[name]] if name in MAPPED else MRCLAM_TITLES[name],
                str(len(runs)),
                f"{len(errors)}",
                f"{sum(one['others'] for one in runs)}",
                f"{1e3 * rms(errors):.1f}",
                f"{1e3 * share(errors, 0.5):.1f}",
                f"{1e3 * max(errors):.1f}",
                f"{1e3 * rms(near):.1f}" if near else "",
                f"{100.0 * tracking / len(again):.1f}" if again else "",
                f"{pace:.0f}",
            ]
        )
    header = ["drives", "number>", "landmarks found>", "twice or where none is>", "rms [mm]>"]
    header += ["median [mm]>", "largest [mm]>", "another drive, five in view, rms [mm]>"]
    return table([*header, "of it TRACKING [%]>", "times real time>"], rows)


def measure_any(name, loopstone, quick):
    if name in MAPPED:
        return measure_mapped(name, loopstone, quick)
    if name in MRCLAM:
        return measure_mrclam(name, loopstone, quick)
    return measure(name, loopstone, quick)


def rms(values):
    return math.sqrt(sum(value * value for value in values) / len(values))


def share(values, quantile):
    return sorted(values)[min(int(quantile * len(values)), len(values) - 1)]


def by_view_table(sections):
    """Only poses that the program calls TRACKING: whoever drives by them drives by these."""
    rows = []
    for name, section in sections.items():
        groups = collections.defaultdict(list)
        for one in section["figures"]:
            for error in one["errors"]:
                if error[4] == "TRACKING":
                    groups[min(error[0], MOST_IN_VIEW)].append(error)
        for in_view, errors in sorted(groups.items()):
            metres = [error[1] for error in errors]
            rows.append(
                [
                    f"{TITLES[name]}; {in_view}" + (" or more" if in_view == MOST_IN_VIEW else ""),
                    f"{len(errors):,}",
                    f"{1e3 * rms(metres):.1f}",
                    f"{1e3 * share(metres, 0.5):.1f}",
                    f"{1e3 * share(metres, 0.99):.1f}",
                    f"{1e3 * max(metres):.1f}",
                    f"{math.degrees(rms([error[2] for error in errors])):.3f}",
                    f"{sum(error[3] for error in errors) / len(errors):.1f}",
                ]
            )
    header = ["drives; landmarks in view", "poses>", "rms [mm]>", "median [mm]>"]
    header += ["99 of 100 below [mm]>", "largest [mm]>", "heading rms [deg]>", "NEES>"]
    return table(header, rows)


def wrong(error):
    return error[1] > RIGHT_M or error[2] > RIGHT_RAD


def by_drive_table(sections):
    rows = []
    for name, section in sections.items():
        runs = section["figures"]
        errors = [error for one in runs for error in one["errors"]]
        scans = sum(one["scans"] for one in runs)
        tracking = [error for error in errors if error[4] == "TRACKING"]
        lost = [error for error in errors if error[4] == "LOST"]
        firsts = [one["first_tracking_m"] for one in runs if one["first_tracking_m"] is not None]
        pace = sum(one["duration_s"] for one in runs) / sum(one["wall_s"] for one in runs)
        rows.append(
            [
                TITLES[name],
                str(len(runs)),
                f"{scans:,}",
                f"{100.0 * len(tracking) / scans:.1f}",
                f"{100.0 * (scans - len(errors) + len(lost)) / scans:.1f}",
                f"{max(firsts):.1f}" if len(firsts) == len(runs) else "never",
                f"{sum(wrong(error) for error in tracking)}",
                f"{sum(not wrong(error) for error in lost)}",
                f"{pace:.0f}",
            ]
        )
    header = ["drives", "number>", "scans>", "TRACKING [%]>", "LOST or no pose yet [%]>"]
    header += ["first TRACKING after, worst [m]>", "TRACKING while wrong>", "LOST while right>"]
    return table([*header, "times real time>"], rows)


def write_blocks(sections, measured, quick):
    """Of those kinds of which something was measured now."""
    mapped = {name: sections[name] for name in [*MAPPED, *MRCLAM] if name in sections}
    followed = {name: sections[name] for name in CASES if name in sections}
    blocks = {}
    if any(name in CASES for name in measured) and followed:
        told = provenance(*followed.values())
        blocks["landmarks-in-view"] = f"{told}\n\n{by_view_table(followed)}"
        blocks["landmarks-drives"] = f"{told}\n\n{by_drive_table(followed)}"
    if any(name not in CASES for name in measured) and mapped:
        blocks["landmarks-mapped"] = f"{provenance(*mapped.values())}\n\n{mapped_table(mapped)}"
    for name, block in blocks.items():
        if quick:
            print(block)
        else:
            write_block(PAGE, name, block)


def main():
    parser = section_parser(__doc__, [*CASES, *MAPPED, *MRCLAM], ROOT)
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    sections, failed = measure_sections(
        "landmarks",
        arguments,
        loopstone,
        lambda name: measure_any(name, loopstone, arguments.quick),
        leave_out=lambda name, kept: arguments.resume and name in kept,
    )
    write_blocks(sections, arguments.only, arguments.quick)
    raise SystemExit(1 if failed else 0)


if __name__ == "__main__":
    main()
