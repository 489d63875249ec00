#!/usr/bin/env python3
"""Measures ray casting and writes the tables of docs/ray_casting.md.

The program is built by `make bench` (-DLOOPSTONE_BENCH=ON). The map is basement_hallways_5cm.png,
looked for in $LOOPSTONE_DATA, else in ../shared/data; without it there is nothing to compare with,
so only a look at a simulated office is printed. What was measured is kept in
build/bench/ray_cast.json.

  bench/ray_cast.py            measures and writes
  bench/ray_cast.py --quick    shorter; to look at, writes nothing into docs/
  bench/ray_cast.py --again    no measurement: writes the tables from ray_cast.json again
"""
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import tables  # noqa: E402
from doc_blocks import table, write_block  # noqa: E402
from program import Loopstone, run  # noqa: E402
from provenance import circumstances  # noqa: E402
from sections import plain_parser  # noqa: E402

PAGE = ROOT / "docs/ray_casting.md"
MAP = "maps/basement_hallways_5cm.png"
TARGET_RAYS_PER_S = 20e6
REPETITIONS = 3
WAYS = [
    ("random", "single rays, anywhere"),
    ("scans60", "scans of 60 beams"),
    ("scans360", "scans of 360 beams"),
]


def measure(program, map_path, quick):
    """{"map": ..., "rows": {(way/caster): counters of the fastest repetition}}; CPU time of one
    thread."""
    command = [
        program,
        *([map_path] if map_path else []),
        "--benchmark_format=json",
        "--benchmark_min_time=0.2",
        f"--benchmark_repetitions={1 if quick else REPETITIONS}",
    ]
    report = json.loads(run(command)[0])
    rows = {}
    for row in report["benchmarks"]:
        if row.get("run_type") == "aggregate":
            continue
        name = "/".join(row["name"].split("/")[:2])
        if name not in rows or row["cpu_time"] < rows[name]["cpu_time"]:
            rows[name] = row
    context = report["context"]
    return {
        "map": pathlib.Path(context["map"]).name,
        "cells": int(context["cells"]),
        "free_cells": int(context["free_cells"]),
        "max_range_m": float(context["max_range_m"]),
        "repetitions": 1 if quick else REPETITIONS,
        "rows": rows,
    }


def casters_of(figures):
    return [name.split("/")[1] for name in figures["rows"] if name.startswith("random/")]


def title(caster):
    if not caster.startswith("table"):
        return caster
    headings = caster[5:].removesuffix("large")
    return f"table, {headings} headings" + (", large pages" if caster.endswith("large") else "")


def speed_table(figures):
    rows = []
    for caster in casters_of(figures):
        of = {way: figures["rows"][f"{way}/{caster}"] for way, _ in WAYS}
        rows.append(
            [
                title(caster),
                *[f"{of[way]['rays_per_s'] / 1e6:.1f}" for way, _ in WAYS],
                f"{of['random']['memory_bytes'] / 1e6:.1f}",
                f"{of['random']['build_s']:.2f}",
            ]
        )
    return table(
        ["caster", *[what + " [10^6 rays/s]>" for _, what in WAYS], "memory [MB]>", "build [s]>"],
        rows,
    )


def accuracy_table(figures):
    rows = []
    for caster in casters_of(figures):
        row = figures["rows"][f"accuracy/{caster}"]
        rows.append(
            [
                title(caster),
                f"{100 * row['same_share']:.1f}",
                f"{100 * row['within_0.1m_share']:.1f}",
                *[f"{row[key]:.3f}" for key in ("error_p50_m", "error_p90_m", "error_p99_m")],
            ]
        )
    return table(
        [
            "caster",
            "same bits as the walk [%]>",
            "within 0.1 m [%]>",
            "median [m]>",
            "90 % [m]>",
            "99 % [m]>",
        ],
        rows,
    )


def weighing_table(figures):
    rows = []
    for caster in casters_of(figures):
        row = figures["rows"][f"weigh2000/{caster}"]
        rows.append([title(caster), f"{row['cpu_time']:.2f}", f"{row['rays_per_s'] / 1e6:.1f}"])
    return table(["caster", "2,000 poses x 60 beams [ms]>", "10^6 beams/s>"], rows)


def target_rows(figures):
    rows = []
    for way, what in WAYS:
        best = max(
            casters_of(figures), key=lambda caster: figures["rows"][f"{way}/{caster}"]["rays_per_s"]
        )
        rate = figures["rows"][f"{way}/{best}"]["rays_per_s"]
        rows.append(
            [
                f"{what}, fastest caster ({title(best)})",
                f"{TARGET_RAYS_PER_S / 1e6:.0f} x 10^6 rays/s",
                f"{rate / 1e6:.1f} x 10^6 rays/s",
                rate >= TARGET_RAYS_PER_S,
            ]
        )
    return rows


def text_of(section):
    figures = section["figures"]
    return "\n".join(
        [
            tables.provenance(section),
            "",
            (
                f"`{figures['map']}`, {figures['cells']:,} cells of which"
                f" {figures['free_cells']:,} are free, rays up to {figures['max_range_m']:.0f} m,"
                f" one thread, CPU time, fastest of {figures['repetitions']} repetitions. Building"
                " is one thread too."
            ),
            "",
            speed_table(figures),
            "",
            "Ranges of single rays against the walk's:",
            "",
            accuracy_table(figures),
            "",
            "The beam model about one place:",
            "",
            weighing_table(figures),
            "",
            tables.targets_table(target_rows(figures)),
        ]
    )


def main():
    parser = plain_parser(__doc__, ROOT)
    parser.add_argument("--again", action="store_true")
    arguments = parser.parse_args()

    arguments.work.mkdir(parents=True, exist_ok=True)
    kept = arguments.work / "ray_cast.json"
    map_path = arguments.data / MAP
    if arguments.again:
        section = json.loads(kept.read_text())
    else:
        loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
        section = {
            **circumstances(loopstone.version()),
            "figures": measure(
                arguments.programs / "bench_ray_cast",
                map_path if map_path.exists() else None,
                arguments.quick,
            ),
        }
    if arguments.quick or not map_path.exists() and not arguments.again:
        print(text_of(section))
        return
    kept.write_text(json.dumps(section, indent=1))
    write_block(PAGE, "ray-casting", text_of(section))


if __name__ == "__main__":
    main()
