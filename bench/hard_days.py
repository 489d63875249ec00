#!/usr/bin/env python3
"""Measures localisation on days that are hard: a laser that is covered or dirty, people, a robot
that is carried, odometry that fails. Each drive has all that is usual in the world
(`loopstone simulate --realism usual`) and one thing more; it is followed on the true map, from a
guess. Writes the table of docs/accuracy.md.

  bench/hard_days.py                          everything (about eight minutes on two processors)
  bench/hard_days.py --days blocked crowd     some; writes nothing into docs/
  bench/hard_days.py --first-seed 200         other drives
  bench/hard_days.py --write                  no measurement: the table from what is kept
"""
import argparse
import concurrent.futures
import json
import math
import os
import pathlib
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from doc_blocks import table, write_block  # noqa: E402
from own_maps_measure import Drive, figures_of, read_poses, rows_of  # noqa: E402
from program import Failed, Loopstone, log_of, run, say  # noqa: E402
from provenance import circumstances, provenance  # noqa: E402
from unkind import ROBOTS, USUAL  # noqa: E402

PAGE, BLOCK = ROOT / "docs/accuracy.md", "localization-hard-days"
BLOCKED_S = 30.0
FAULT_FROM_S, FAULT_TO_S = 60.0, 120.0
WITH = {
    "usual": [],
    "blocked": ["--set", f"realism.blocked.length_s={BLOCKED_S:g}"],
    "dirty": [],
    "follower": [],
    "ahead": [],
    "crowd": [],
    "carried": [],
    "carried_blind": [],
    "glass": [],
    "mirrors": [],
    "upside_down": [],
}
FAULTS = "missing stuck scaled mirrored lagging jumping".split()
DAYS = [*WITH, *(f"odometry {fault}" for fault in FAULTS)]
TITLES = {
    "usual": "no more than usual",
    "blocked": f"the laser is covered for {BLOCKED_S:g} s",
    "dirty": "a dirty laser",
    "follower": "somebody follows",
    "ahead": "somebody walks ahead",
    "crowd": "a crowd",
    "carried": "carried by 3 m",
    "carried_blind": "carried by 3 m, and no scans meanwhile",
    "glass": "walls of glass",
    "mirrors": "mirrors",
    "upside_down": "a laser upside down",
}
WORLDS = ["office", "warehouse", "campus", "loops"]
# Limits were chosen on small seeds.
FIRST_SEED = 2000
DURATION_S = 240.0
# The stamp at which simulated drives begin.
START_S = 1000.0
# How far off the guess is [m, m, rad], in the robot's frame.
GUESS = (0.2, -0.1, 0.1)
# What lies so long after a spoil has nothing to do with it [m].
AFTER_M = 20.0


def title_of(day):
    if day in TITLES:
        return TITLES[day]
    fault = day.split()[1]
    return f"odometry that is {fault}, from {FAULT_FROM_S:g} to {FAULT_TO_S:g} s"


def simulation(day, world, robot, seed):
    words = ["simulate", world, "--seed", str(seed), "--duration", f"{DURATION_S:g}"]
    words += ROBOTS[robot]
    if day in WITH:
        effects = USUAL if day == "usual" else f"{USUAL},{day}"
        return [*words, "--realism", effects, *WITH[day]]
    times = [f"faults.from_s={FAULT_FROM_S:g}", f"faults.to_s={FAULT_TO_S:g}"]
    words += ["--realism", USUAL, "--odometry-fault", day.split()[1]]
    return words + [word for time in times for word in ("--set", time)]


def guess_of(truth):
    x, y, yaw = truth[min(truth, key=float)]
    c, s = math.cos(yaw), math.sin(yaw)
    ahead, left, turn = GUESS
    guess = (x + c * ahead - s * left, y + s * ahead + c * left, yaw + turn)
    return ",".join(f"{value:.4f}" for value in guess)


def spoils_of(folder, day):
    """When what the day is called after was over, by stamps."""
    if day not in WITH:
        return [START_S + FAULT_TO_S]
    spoils = json.loads((folder / "world.json").read_text())["realism"]["spoils"]
    return [spoil["to_stamp_s"] for spoil in spoils if spoil["effect"] == day]


def way_until_right(rows, stamps, end):
    """From the end of a spoil to the last wrong pose after it [m]; none: the spoil never ended."""
    after = [row for row, stamp in zip(rows, stamps) if stamp > end]
    if not after:
        return None
    start = after[0]["travelled_m"]
    wrong = [
        row["travelled_m"] - start
        for row in after
        if not row["right"] and row["travelled_m"] - start < AFTER_M
    ]
    return max(wrong, default=0.0)


def measured(loopstone, day, world, robot, seed):
    name = f"{day.replace(' ', '-')}-{world}-{robot}-{seed}"
    folder = loopstone.work / f"sim-{name}"
    where = loopstone.work / f"where-{name}.tum"
    run(
        [loopstone.program, *simulation(day, world, robot, seed), "-o", folder]
        + ["--force", "--quiet"]
    )
    truth = read_poses(folder / "truth.tum")
    flags = ["--map", folder / "map.yaml", "-o", where, "--initial", guess_of(truth)]
    command = [loopstone.program, "localize", log_of(folder), *flags, "--threads", "1"]
    _, cost = run([*command, "--force", "--quiet"])
    table_of = where.with_suffix(".csv")
    rows = rows_of(table_of, truth)
    drive = Drive(day, name, world, rows, cost["cpu_s"])
    stamps = [float(line.split(",")[0]) for line in table_of.read_text().splitlines()[1:]]
    ends = spoils_of(folder, day) if len(stamps) == len(rows) else []
    ways = [way_until_right(rows, stamps, end) for end in ends]
    figures = {
        **figures_of(drive),
        "wrong_m": longest_wrong(rows),
        "ways_m": [way for way in ways if way is not None],
    }
    shutil.rmtree(folder)
    where.unlink()
    table_of.unlink()
    return {"day": day, "world": world, "robot": robot, "seed": seed, **figures}


def longest_wrong(rows):
    """The longest way on which the robot is TRACKING and wrong [m]."""
    longest, since = 0.0, None
    for row in rows:
        if row["state"] != "TRACKING" or row["right"]:
            since = None
            continue
        since = row["travelled_m"] if since is None else since
        longest = max(longest, row["travelled_m"] - since)
    return longest


def planned(days, first_seed):
    robots = list(ROBOTS)
    for i, day in enumerate(DAYS):
        for j, world in enumerate(WORLDS):
            if day in days:
                yield day, world, robots[(i + j) % len(robots)], first_seed + len(WORLDS) * i + j


def told(one):
    return (
        f"right {100 * one['right']:.2f} %, TRACKING {100 * one['tracking']:.2f} %, and wrong"
        f" {100 * one['wrong']:.3f} % (up to {one['wrong_m']:.1f} m), LOST"
        f" {100 * one['lost']:.2f} %, right again after"
        f" {', '.join(f'{way:.2f}' for way in one['ways_m']) or '-'} m"
    )


def measure_all(arguments):
    work = arguments.work / "hard_days"
    work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.program, work)
    kept = {**circumstances(loopstone.version()), "drives": []}
    plan = list(planned(arguments.days, arguments.first_seed))

    def one(drive):
        try:
            return measured(loopstone, *drive)
        except (Failed, OSError, KeyError, ValueError) as failure:
            return {"failed": str(failure).splitlines()[-1:]}

    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for drive, done in zip(plan, pool.map(one, plan)):
            said = f"FAILED {done['failed']}" if "failed" in done else told(done)
            say(f"  {' '.join(map(str, drive))}: {said}")
            if "failed" not in done:
                kept["drives"].append(done)
    return kept


def mean(values):
    values = list(values)
    return sum(values) / len(values)


def line_of(title, drives):
    ways = [way for drive in drives for way in drive["ways_m"]]
    return [
        title,
        f"{sum(drive['scans'] for drive in drives):,}",
        *(f"{100 * mean(drive[name] for drive in drives):.2f}" for name in ("right", "tracking")),
        f"{100 * mean(drive['wrong'] for drive in drives):.3f}",
        f"{max(drive['wrong_m'] for drive in drives):.1f}",
        f"{100 * mean(drive['lost'] for drive in drives):.2f}",
        f"{mean(drive['changes_100m'] for drive in drives):.1f}",
        f"{max(ways):.2f}" if ways else "-",
    ]


HEADER = [
    "day",
    "scans>",
    "right [%]>",
    "TRACKING [%]>",
    "wrong while TRACKING [%]>",
    "longest way so [m]>",
    "LOST [%]>",
    "changes of state in 100 m>",
    "right again after, most [m]>",
]


def text_of(kept):
    days = {}
    for drive in kept["drives"]:
        days.setdefault(drive["day"], []).append(drive)
    lines = [line_of(title_of(day), drives) for day, drives in days.items()]
    lines.append(line_of("**all**", kept["drives"]))
    return "\n\n".join([provenance(kept), table(HEADER, lines)])


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--program", default=ROOT / "build/release/bin/loopstone")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/bench")
    parser.add_argument("--days", nargs="+", choices=DAYS, default=None)
    parser.add_argument("--first-seed", type=int, default=FIRST_SEED)
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--quick", action="store_true", help="the first days; writes nothing")
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    is_whole = not (arguments.days or arguments.quick) and arguments.first_seed == FIRST_SEED
    path = arguments.work / f"hard_days{'' if is_whole else '-some'}.json"
    arguments.days = arguments.days or (DAYS[:2] if arguments.quick else DAYS)
    kept = json.loads(path.read_text()) if arguments.write else measure_all(arguments)
    if not arguments.write:
        path.write_text(json.dumps(kept, indent=1))
    text = text_of(kept)
    if is_whole:
        write_block(PAGE, BLOCK, text)
    print(text)


if __name__ == "__main__":
    main()
