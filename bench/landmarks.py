#!/usr/bin/env python3
"""Follows simulated robots by reflectors alone, from nowhere, and holds their poses against the
truth: by how many landmarks a reading shows, and by drive. Writes two tables of
docs/localization.md.

  bench/landmarks.py                     everything (about ten minutes, most of it simulation)
  bench/landmarks.py --only office       some cases
  bench/landmarks.py --quick             one seed, short drives; to look at, writes nothing
"""
import collections
import csv
import json
import math
import pathlib
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
SEEDS = range(1, 4)
DURATION_S = 120
MOST_IN_VIEW = 5  # and more
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


def main():
    parser = section_parser(__doc__, list(CASES), ROOT, None)
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    sections, failed = measure_sections(
        "landmarks",
        arguments,
        loopstone,
        lambda name: measure(name, loopstone, arguments.quick),
        leave_out=lambda name, kept: arguments.resume and name in kept,
    )
    if sections:
        sections = {name: sections[name] for name in CASES if name in sections}
        told = provenance(*sections.values())
        view = f"{told}\n\n{by_view_table(sections)}"
        drives = f"{told}\n\n{by_drive_table(sections)}"
        if arguments.quick:
            print(view, drives, sep="\n\n")
        else:
            write_block(PAGE, "landmarks-in-view", view)
            write_block(PAGE, "landmarks-drives", drives)
    raise SystemExit(1 if failed else 0)


if __name__ == "__main__":
    main()
