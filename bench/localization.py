#!/usr/bin/env python3
"""Measures localisation on maps of which the truth is known, and on recorded logs, and writes the tables of docs/accuracy.md.

The programs are built by `make bench` (-DLOOPSTONE_BENCH=ON). Maps and logs are looked for in $LOOPSTONE_DATA, else in
../shared/data. What was measured is kept in build/bench/localization.json, every single drive in build/bench/localization.

  bench/localization.py                      everything (about half an hour on one core)
  bench/localization.py --quick              a few seeds; to look at, writes nothing into docs/
  bench/localization.py --only global kidnap some sections
  bench/localization.py --resume             goes on where it was interrupted: leaves out the drives that are there
  bench/localization.py --only               no measurement: writes the tables from localization.json again
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import localization_measure as measure  # noqa: E402
import localization_tables as tables  # noqa: E402
from doc_blocks import write_block  # noqa: E402
from measure import data_folder  # noqa: E402
from program import Failed, Loopstone, machine, say  # noqa: E402

PAGE = "docs/accuracy.md"
DRIVES = {"tracking": measure.tracking, "global": measure.global_start, "ambiguous": measure.ambiguous,
          "kidnap": measure.kidnapping, "changed": measure.changed}
SECTIONS = [*DRIVES, "recorded"]


def measure_section(name, arguments, loopstone):
    folder = arguments.work / "localization"
    if name == "recorded":
        return measure.recorded(loopstone, arguments.data, folder, arguments.quick)
    drives = measure.Drives(arguments.programs / "measure_localization", arguments.data, folder / f"{name}.jsonl",
                            arguments.resume)
    return DRIVES[name](drives, arguments.quick)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/release/bin")
    parser.add_argument("--data", type=pathlib.Path, default=data_folder(ROOT, os.environ))
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/bench")
    parser.add_argument("--only", nargs="*", choices=SECTIONS, default=SECTIONS)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--resume", action="store_true", help="leave out the drives that have been measured")
    arguments = parser.parse_args()

    (arguments.work / "localization").mkdir(parents=True, exist_ok=True)
    kept = arguments.work / ("localization-quick.json" if arguments.quick else "localization.json")
    sections = json.loads(kept.read_text()) if kept.exists() else {}
    failed = []
    for name in arguments.only:
        say(f"{name}:")
        started = time.monotonic()
        loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
        circumstances = {"machine": machine(), "version": loopstone.version(),
                         "command": "bench/localization.py" + (" --quick" if arguments.quick else "")}
        try:
            figures = measure_section(name, arguments, loopstone)
        except (Failed, OSError, subprocess.SubprocessError, ValueError, KeyError) as failure:
            say(f"  FAILED: {failure!r}")
            failed.append(name)
            continue
        say(f"  took {time.monotonic() - started:.0f} s")
        if figures:
            sections[name] = {**circumstances, "figures": figures}
            kept.write_text(json.dumps(sections, indent=1))

    for name in SECTIONS:
        if name not in sections:
            continue
        text = tables.text_of(name, sections[name])
        if not arguments.quick:
            write_block(ROOT / PAGE, f"localization-{name}", text)
        elif name in arguments.only:
            print(f"\n{PAGE}: localization-{name}\n{text}")
    for name, target, measured, met in tables.targets_of(sections):
        print(f"{'met    ' if met else 'NOT MET'}  {measured:>14}  {target:<18} {name}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
