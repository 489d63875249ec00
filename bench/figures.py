#!/usr/bin/env python3
"""Measures accuracy and speed of whole runs and writes the tables of docs/accuracy.md, docs/benchmarks.md and README.md.

Recorded logs are looked for in $LOOPSTONE_DATA, else in ../shared/data; without them those tables stay as they are.
What was measured is kept in build/bench/figures.json, so a later run of one section leaves the others standing.

  bench/figures.py                      everything (about half an hour)
  bench/figures.py --quick              fewer seeds and repeats; to look at, writes nothing into docs/
  bench/figures.py --only real speed    some sections
  bench/figures.py --only               no measurement: writes the tables from figures.json again
"""
import argparse
import json
import os
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
from program import Loopstone, machine, say  # noqa: E402

SECTIONS = ["speed", "laps", "online", "peers", "real", "simulated", "demo"]  # the timing first, while nothing else has warmed or filled the machine


def measure_section(name, loopstone, data, quick):
    if name == "real":
        return measure.real_logs(loopstone, data)
    if name == "simulated":
        return measure.simulated(loopstone, quick)
    if name == "demo":
        return measure.demo(loopstone)
    if name == "peers":
        return measure.peers(loopstone, data, 2 if quick else 5)
    if name == "laps":
        return measure.laps(loopstone)
    if name == "online":
        return measure.online(loopstone, data)
    return measure.speed(loopstone, data, 2 if quick else 5)


def blocks_of(sections):
    """(page, block, text) of everything that the measured sections say."""
    blocks = []
    if "real" in sections:
        blocks.append(("docs/accuracy.md", "accuracy-real", tables.real_tables(sections["real"])))
    if "simulated" in sections:
        blocks.append(("docs/accuracy.md", "accuracy-simulated", tables.simulated_tables(sections["simulated"])))
    if "speed" in sections:
        blocks.append(("docs/benchmarks.md", "speed", tables.speed_tables(sections["speed"])))
        blocks.append(("docs/benchmarks.md", "stages", tables.stage_table(sections["speed"])))
    if "laps" in sections:
        blocks.append(("docs/benchmarks.md", "laps", tables.laps_table(sections["laps"])))
    if "peers" in sections:
        blocks.append(("docs/benchmarks.md", "peers", tables.peers_table(sections["peers"])))
    if "online" in sections:
        blocks.append(("docs/benchmarks.md", "online", tables.online_table(sections["online"])))
    if "real" in sections or "simulated" in sections:
        blocks.append(("README.md", "headline", tables.headline(sections)))
    if "demo" in sections:
        blocks.append(("README.md", "demo", tables.session(sections["demo"])))
    return blocks


def summary(sections):
    rows = []
    if "real" in sections:
        rows += targets.of_real(sections["real"]["figures"])
    if "simulated" in sections:
        rows += targets.of_simulated(sections["simulated"]["figures"])
    if "speed" in sections:
        rows += targets.of_speed(sections["speed"]["figures"])
    if "laps" in sections:
        rows += targets.of_laps(sections["laps"]["figures"])
    if "online" in sections:
        rows += targets.of_online(sections["online"]["figures"])
    return "\n".join(f"{'met    ' if met else 'NOT MET'}  {measured:>10}  {target:<24} {name}"
                     for name, target, measured, met in rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/loopstone"))
    parser.add_argument("--data", type=pathlib.Path, default=measure.data_folder(ROOT, os.environ))
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
        circumstances = {"machine": machine(), "version": loopstone.version(),
                         "command": "bench/figures.py" + (" --quick" if arguments.quick else "")}
        started = time.monotonic()
        figures = measure_section(name, loopstone, arguments.data, arguments.quick)
        say(f"  took {time.monotonic() - started:.0f} s")
        if figures:
            sections[name] = {**circumstances, "figures": figures}
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
