#!/usr/bin/env python3
"""Measures accuracy and speed of whole runs and writes the tables of docs/accuracy.md,
docs/benchmarks.md and README.md.

Recorded logs are looked for in $LOOPSTONE_DATA, else in ../shared/data; without them those tables
stay as they are. What was measured is kept in build/bench/figures.json, so a later run of one
section leaves the others standing.

  bench/figures.py                      everything (about half an hour)
  bench/figures.py --quick              fewer seeds and repeats; to look at, writes nothing into
                                        docs/
  bench/figures.py --only real speed    some sections
  bench/figures.py --only               no measurement: writes the tables from figures.json again
"""
import argparse
import json
import pathlib
import shutil
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import measure  # noqa: E402
import tables  # noqa: E402
import targets  # noqa: E402
from doc_blocks import write_block  # noqa: E402
from program import Loopstone, say  # noqa: E402
from provenance import circumstances  # noqa: E402
from recorded import data_folder  # noqa: E402

SECTIONS = [
    "speed",
    "laps",
    "online",
    "peers",
    "real",
    "simulated",
    "live_map",
    "demo",
]  # the timing first, while nothing else has warmed or filled the machine


def measure_section(name, loopstone, data, quick):
    repeats = 2 if quick else 5
    measures = {
        "speed": lambda: measure.speed(loopstone, data, repeats),
        "laps": lambda: measure.laps(loopstone),
        "online": lambda: measure.online(loopstone, data, quick),
        "live_map": lambda: measure.live_map(loopstone, data),
        "peers": lambda: measure.peers(loopstone, data, repeats),
        "real": lambda: measure.real_logs(loopstone, data),
        "simulated": lambda: measure.simulated(loopstone, quick),
        "demo": lambda: measure.demo(loopstone),
    }
    return measures[name]()


# section, page, block, its text
BLOCKS = [
    ("real", "docs/accuracy.md", "accuracy-real", tables.real_tables),
    ("simulated", "docs/accuracy.md", "accuracy-simulated", tables.simulated_tables),
    ("speed", "docs/benchmarks.md", "speed", tables.speed_tables),
    ("speed", "docs/benchmarks.md", "stages", tables.stage_table),
    ("laps", "docs/benchmarks.md", "laps", tables.laps_table),
    ("peers", "docs/benchmarks.md", "peers", tables.peers_table),
    ("online", "docs/benchmarks.md", "online", tables.online_table),
    ("live_map", "docs/accuracy.md", "live-map", tables.live_map_table),
    ("demo", "README.md", "demo", tables.session),
]
# page, block, the sections whose targets a page begins with
OVERVIEWS = [
    ("docs/accuracy.md", "accuracy-overview", ["real", "simulated"]),
    ("docs/benchmarks.md", "speed-overview", ["speed", "laps", "online"]),
]


def blocks_of(sections):
    """(page, block, text) of everything that the measured sections say."""
    blocks = [
        (page, block, text_of(sections[name]))
        for name, page, block, text_of in BLOCKS
        if name in sections
    ]
    blocks += [
        (page, block, tables.overview(sections, names))
        for page, block, names in OVERVIEWS
        if any(name in sections for name in names)
    ]
    if "real" in sections or "simulated" in sections:
        blocks.append(("README.md", "headline", tables.headline(sections)))
    return blocks


def summary(sections):
    rows = targets.of_sections(sections, targets.OF_SECTION)
    return "\n".join(
        f"{'met    ' if met else 'NOT MET'}  {measured:>10}  {target:<24} {name}"
        for name, target, measured, met in rows
    )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/loopstone"))
    parser.add_argument("--data", type=pathlib.Path, default=data_folder(ROOT))
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/bench")
    parser.add_argument("--only", nargs="*", choices=SECTIONS, default=SECTIONS)
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()

    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.program, arguments.work)
    kept = arguments.work / ("figures-quick.json" if arguments.quick else "figures.json")
    sections = json.loads(kept.read_text()) if kept.exists() else {}
    for name in arguments.only:
        say(f"{name}:")
        when = circumstances(loopstone.version())
        started = time.monotonic()
        figures = measure_section(name, loopstone, arguments.data, arguments.quick)
        say(f"  took {time.monotonic() - started:.0f} s")
        if figures:
            sections[name] = {**when, "figures": figures}
            kept.write_text(json.dumps(sections, indent=1))

    for page, block, text in blocks_of(sections):
        if arguments.quick:
            print(f"\n{page}: {block}\n{text}")
        else:
            write_block(ROOT / page, block, text)
    picture = arguments.work / "map-mit-csail/map.png"
    if "real" in arguments.only and picture.exists() and not arguments.quick:
        shutil.copy(picture, ROOT / "docs/images/csail_map.png")
    print(summary(sections))


if __name__ == "__main__":
    main()
