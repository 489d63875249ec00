#!/usr/bin/env python3
"""Measures localisation on maps of which the truth is known, and on recorded logs, and writes the
tables of docs/accuracy.md.

The programs are built by `make bench` (-DLOOPSTONE_BENCH=ON). Maps and logs are looked for in
$LOOPSTONE_DATA, else in ../shared/data. What was measured is kept in build/bench/localization.json,
every single drive in build/bench/localization.

  bench/localization.py                      everything (about half an hour on one core)
  bench/localization.py --quick              a few seeds; to look at, writes nothing into docs/
  bench/localization.py --only global kidnap some sections
  bench/localization.py --resume             goes on where it was interrupted: leaves out the drives
                                             that are there
  bench/localization.py --only               no measurement: writes the tables from
                                             localization.json again
"""
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import localization_measure as measure  # noqa: E402
import localization_tables as tables  # noqa: E402
from doc_blocks import write_block  # noqa: E402
from program import Loopstone  # noqa: E402
from sections import measure_sections, section_parser, verdicts  # noqa: E402

PAGE = "docs/accuracy.md"
DRIVES = {
    "tracking": measure.tracking,
    "global": measure.global_start,
    "ambiguous": measure.ambiguous,
    "kidnap": measure.kidnapping,
    "changed": measure.changed,
}
SECTIONS = [*DRIVES, "recorded"]


def measure_section(name, arguments, loopstone):
    folder = arguments.work / "localization"
    if name == "recorded":
        return measure.recorded(loopstone, arguments.data, folder, arguments.quick)
    drives = measure.Drives(
        arguments.programs / "measure_localization",
        arguments.data,
        folder / f"{name}.jsonl",
        arguments.resume,
    )
    return DRIVES[name](drives, arguments.quick)


def main():
    arguments = section_parser(__doc__, SECTIONS, ROOT).parse_args()
    (arguments.work / "localization").mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    sections, failed = measure_sections(
        "localization",
        arguments,
        loopstone,
        lambda name: measure_section(name, arguments, loopstone),
    )

    for name in SECTIONS:
        if name not in sections:
            continue
        text = tables.text_of(name, sections[name])
        if not arguments.quick:
            write_block(ROOT / PAGE, f"localization-{name}", text)
        elif name in arguments.only:
            print(f"\n{PAGE}: localization-{name}\n{text}")
    print(verdicts(tables.targets_of(sections)))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
