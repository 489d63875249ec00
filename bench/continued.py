#!/usr/bin/env python3
"""Measures what it costs a map to be made of two drives: a recorded log is cut in halves, the
second goes on with the map of the first from nowhere on it, and the relations of the whole are
compared with those of the log mapped at once. Writes the table of docs/session.md.

  bench/continued.py            some minutes
  bench/continued.py --quick    to look at; writes nothing into docs/
"""
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import tables  # noqa: E402
from doc_blocks import table, write_block  # noqa: E402
from program import Loopstone, say  # noqa: E402
from provenance import circumstances  # noqa: E402
from sections import plain_parser, verdicts  # noqa: E402

PAGE, BLOCK = "docs/session.md", "continued"
LOGS = [("Intel", "intel"), ("ACES", "aces")]
TARGET_RATIO = 1.3


def relations(loopstone, trajectory, path):
    return loopstone.evaluate("--estimate", trajectory, "--relations", path)


def joined_trajectory(folder):
    """Both drives with the stamps of their log, which was one."""
    lines = []
    for part in sorted(folder.glob("trajectory_drive_*.tum")):
        lines += part.read_text(encoding="utf-8").splitlines()
    path = folder / "both.tum"
    path.write_text("\n".join(line for line in lines if line[0] != "#") + "\n", encoding="utf-8")
    return path


def measure(loopstone, title, log, path):
    whole, summary, cost = loopstone.map(log, f"{title}-whole")
    half_s = summary["duration_s"] / 2
    first, _, _ = loopstone.map(
        log, f"{title}-first", ["--duration", f"{half_s:.1f}", "--keep-state"]
    )
    both, after, after_cost = loopstone.map(
        log, f"{title}-both", ["--start", f"{half_s:.1f}", "--continue", str(first)]
    )
    drive = after["drives"][0]
    at_once = relations(loopstone, whole / "trajectory.tum", path)
    in_two = relations(loopstone, joined_trajectory(both), path)
    say(f"  {title}: joined {drive['joined']}")
    return {
        "title": title,
        "joined": drive["joined"],
        "closures": drive["closures"],
        "whole_m": at_once["translation_error_m"]["mean"],
        "both_m": in_two["translation_error_m"]["mean"],
        "whole_deg": at_once["rotation_error_deg"]["mean"],
        "both_deg": in_two["rotation_error_deg"]["mean"],
        "whole_s": cost["cpu_s"],
        "second_s": after_cost["cpu_s"],
    }


def text_of(section):
    rows = [
        [
            row["title"],
            "yes" if row["joined"] else "no",
            str(row["closures"]),
            f"{row['whole_m']:.3f}",
            f"{row['both_m']:.3f}",
            f"{row['whole_deg']:.2f}",
            f"{row['both_deg']:.2f}",
            f"{row['whole_s']:.1f}",
            f"{row['second_s']:.1f}",
        ]
        for row in section["figures"]
    ]
    header = [
        "log",
        "joined",
        "closures>",
        "translation, at once [m]>",
        "in two drives [m]>",
        "rotation, at once [deg]>",
        "in two drives [deg]>",
        "CPU, at once [s]>",
        "the second drive [s]>",
    ]
    return "\n".join(
        [
            tables.provenance(section),
            "",
            table(header, rows),
            "",
            tables.targets_table(targets_of(section["figures"])),
        ]
    )


def targets_of(rows):
    return [
        (
            f"{row['title']}: translation error of the relations in two drives / at once",
            f"<= {TARGET_RATIO:g}",
            f"{row['both_m'] / row['whole_m']:.2f}",
            row["both_m"] <= TARGET_RATIO * row["whole_m"],
        )
        for row in rows
    ]


def main():
    arguments = plain_parser(__doc__, ROOT).parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    section = circumstances(loopstone.version())
    rows = []
    for title, name in LOGS[: 1 if arguments.quick else None]:
        log = arguments.data / "carmen" / f"{name}.clf"
        if not log.exists():
            say(f"  {log}: not there, skipped")
            continue
        rows.append(measure(loopstone, title, log, log.with_suffix(".relations")))
    if not rows:
        return
    section["figures"] = rows
    (arguments.work / "continued.json").write_text(json.dumps(section, indent=1))
    text = text_of(section)
    if arguments.quick:
        print(text)
    elif write_block(ROOT / PAGE, BLOCK, text):
        say(f"wrote {PAGE}: {BLOCK}")
    print(verdicts(targets_of(rows)))


if __name__ == "__main__":
    main()
