#!/usr/bin/env python3
"""Holds the plans of `loopstone export` to what stands in simulated worlds: walls, rooms, doors.

Writes the table of docs/plans.md. Numbers of src/plan were chosen on the seeds called "chosen on";
the rows of the seeds called "checked on" are the ones that count. Needs shapely
(scripts/install_oracles.sh) and measure_plan_truth (a build with LOOPSTONE_BENCH=ON).

  bench/plans.py                     everything, some minutes
  bench/plans.py --quick             one seed of each world; prints the table, writes nothing
  bench/plans.py --worlds office     some worlds
"""
import json
import os
import pathlib
import statistics
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PYTHON = ROOT / "build/oracles/venv/bin/python"
if PYTHON.exists() and pathlib.Path(sys.prefix) != PYTHON.parent.parent:
    os.execv(PYTHON, [str(PYTHON), *sys.argv])
sys.path.insert(0, str(ROOT / "scripts"))

try:
    import plans_measure as plans  # noqa: E402
except ImportError as missing:
    sys.exit(f"needs numpy and shapely ({missing}): run scripts/install_oracles.sh first")
from doc_blocks import table, write_block  # noqa: E402
from program import Failed, Loopstone, log_of, run, say  # noqa: E402
from provenance import circumstances, provenance  # noqa: E402
from sections import plain_parser  # noqa: E402

PAGE = ROOT / "docs/plans.md"
CHOSEN_ON, CHECKED_ON = [1, 2], [31, 32]
# Of docs/simulation.md what spoils sensors, and leaves the world as it is.
UNKIND = "range,mixed,dropouts,steps,sweep,mount,stamps,loss,wheels,gyro"
# name, world, flags of simulate
WORLDS = [
    ("office", "office", []),
    ("office, unkind sensors", "office", ["--realism", UNKIND]),
    ("rooms", "rooms", []),
    ("wings", "wings", []),
    ("warehouse", "warehouse", []),
]
ANCHOR = (0.0, 0.0)
CLOSE = 0.01  # of an area: the target
SAME_ROOM = 0.8  # of their union two rooms share when they are the same


def measure(loopstone, programs, case, seed):
    """One map, drawn through its scans and through its cells."""
    _, world, flags = case
    sim = loopstone.simulate(world, seed, flags)
    folder, _, _ = loopstone.map(log_of(sim), "plans", ["--keep-state"])
    truth = plans.Truth(programs / "measure_plan_truth", world, seed)
    move = plans.Mover(plans.aligned(folder / "trajectory.tum", sim / "truth.tum"))
    errors = loopstone.evaluate(
        *("--estimate", folder / "trajectory.tum", "--reference", sim / "truth.tum")
    )
    rows = []
    for source, path in [("scans", folder), ("cells", folder / "map.yaml")]:
        drawn = loopstone.work / "plan.geojson"
        output, cost = run(
            [
                *(loopstone.program, "export", path, "--geojson", drawn, "--force"),
                *("--anchor", f"{ANCHOR[0]},{ANCHOR[1]},90", "--json", "--quiet"),
            ]
        )
        plan = plans.features(drawn, ANCHOR)
        rows.append(
            {
                "source": source,
                "ate_m": errors["ate_rmse_m"],
                "axes": len(json.loads(output)["axes"]),
                "wall_s": cost["wall_s"],
                **plans.wall_figures(truth, plan, move, folder),
                "rooms": plans.room_figures(truth, plan, move),
                "doors": plans.door_figures(truth, plan, move),
            }
        )
    return rows


def text_of_rows(name, seeds, source, rows):
    total = lambda key: sum(row[key] for row in rows)  # noqa: E731
    weighted = lambda key: sum(row[key] * row["seen_m"] for row in rows) / total(
        "seen_m"
    )  # noqa: E731
    rooms = [room for row in rows for room in row["rooms"]]
    same = [room for room in rooms if room["overlap"] >= SAME_ROOM]
    off = [abs(room["area_m2"] / room["true_m2"] - 1.0) for room in same if room["closed"]]
    closed = [room for room in rooms if room["closed"]]
    doors = {key: sum(row["doors"][key] for row in rows) for key in ("found", "missed", "false")}
    widths = [row["doors"]["width_rms_m"] ** 2 for row in rows if row["doors"]["found"]]
    return [
        name,
        seeds,
        source,
        f"{1e3 * max(row['ate_m'] for row in rows):.1f}",
        f"{total('seen_m'):.0f}",
        f"{100 * weighted('within'):.1f}",
        f"{100 * weighted('within_any'):.1f}",
        f"{100 * total('extra_m') / total('drawn_m'):.1f}",
        str(len(rooms)),
        str(len(closed)),
        str(sum(o <= CLOSE for o in off)),
        f"{100 * statistics.median(off):.2f}" if off else "",
        f"{doors['found']} of {doors['found'] + doors['missed']}",
        str(doors["false"]),
        f"{1e3 * statistics.mean(widths) ** 0.5:.0f}" if widths else "",
        f"{statistics.mean(row['wall_s'] for row in rows):.1f}",
    ]


HEADER = [
    "world",
    "seeds",
    "lines through",
    "ATE, worst [mm]>",
    "wall seen [m]>",
    "within 2 cm [%]>",
    "of any layer [%]>",
    "walls drawn where none is [%]>",
    "rooms>",
    "closed>",
    "of them within 1 % of the area>",
    "area off, median [%]>",
    "doors found>",
    "others drawn>",
    "width off, rms [mm]>",
    "time [s]>",
]


def text_of(kept, when):
    rows = []
    for group, seeds in [("chosen on", CHOSEN_ON), ("checked on", CHECKED_ON)]:
        for name, _, _ in WORLDS:
            for source in ("scans", "cells"):
                found = [
                    row
                    for case, seed, measured in kept
                    for row in measured
                    if case == name and seed in seeds and row["source"] == source
                ]
                if found:
                    rows.append(text_of_rows(name, group, source, found))
    return provenance(when) + "\n\n" + table(HEADER, rows)


def main():
    parser = plain_parser(__doc__, ROOT)
    parser.add_argument("--worlds", nargs="*", choices=sorted({case[1] for case in WORLDS}))
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    when = circumstances(loopstone.version())
    kept, failed = [], False
    seeds = [CHECKED_ON[0]] if arguments.quick else [*CHOSEN_ON, *CHECKED_ON]
    for case in WORLDS:
        if arguments.worlds and case[1] not in arguments.worlds:
            continue
        for seed in seeds:
            say(f"  {case[0]}, seed {seed}")
            try:
                kept.append((case[0], seed, measure(loopstone, arguments.programs, case, seed)))
            except (Failed, OSError, ValueError, KeyError) as failure:
                say(f"  FAILED: {failure!r}")
                failed = True
    text = text_of(kept, when)
    if arguments.quick or arguments.worlds:
        print(text)
    elif kept:
        write_block(PAGE, "plans", text)
    raise SystemExit(1 if failed else 0)


if __name__ == "__main__":
    main()
