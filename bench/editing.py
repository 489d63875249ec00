#!/usr/bin/env python3
"""Measures what it costs to edit a map by hand: to open it, an edit of each kind that touches the
graph, and to draw it. Writes the table of docs/editing.md.

  bench/editing.py            a minute
  bench/editing.py --quick    to look at; writes nothing into docs/
"""
import csv
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import tables  # noqa: E402
from doc_blocks import table, write_block  # noqa: E402
from program import Loopstone, log_of, median, run, say  # noqa: E402
from provenance import circumstances  # noqa: E402
from sections import plain_parser, verdicts  # noqa: E402

PAGE, BLOCK = "docs/editing.md", "editing-cost"
TARGET_EDIT_S = 0.5
EDITS = 5  # of each kind; the median counts


def standing(folder):
    """Closures that are plain enough to be found again by other scans around the places."""
    with open(folder / "loop_closures.csv", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["accepted"] == "1"]
    return [row for row in rows if float(row["overlap"]) > 0.6 and float(row["agreement"]) > 0.9]


def spread(rows, count):
    return [rows[(2 * i + 1) * len(rows) // (2 * count)] for i in range(count)]


def named(row):
    return f'from_node = {row["from_node"]}\nto_node = {row["to_node"]}\n'


def edits_of(folder, duration_s):
    """Closures are deleted, then added again from a guess somewhat beside; stretches are ignored;
    the frame is set and zones are drawn."""
    chosen = spread(standing(folder), EDITS)
    edits = ['kind = "delete_closure"\n' + named(row) for row in chosen]
    for row in chosen:
        x_m, y_m = float(row["x_m"]) + 0.2, float(row["y_m"]) - 0.2
        edits.append(
            f'kind = "add_closure"\n{named(row)}x_m = {x_m}\ny_m = {y_m}\n'
            f'yaw_rad = {row["yaw_rad"]}\n'
        )
    for i in range(EDITS):
        begin_s = duration_s * (2 * i + 1) / (2 * EDITS)
        edits.append(f'kind = "ignore"\nfrom_s = {begin_s:.1f}\nto_s = {begin_s + 5:.1f}\n')
    edits.append('kind = "straighten"\n')
    edits.append('kind = "keep_out"\nbox = [0, 0, 2, 2]\n')
    return "".join(f"[[edit]]\n{edit}\n" for edit in edits)


def seconds_of(edits, kind):
    return median([edit["wall_s"] for edit in edits["list"] if edit["kind"] == kind])


def measure(loopstone, title, log, name):
    folder, summary, _ = loopstone.map(log, name, ["--keep-state"])
    path = loopstone.work / f"{name}.toml"
    path.write_text(edits_of(folder, summary["duration_s"]), encoding="utf-8")
    out = loopstone.work / f"edited-{name}"
    run([loopstone.program, "edit", folder, "--edits", path, "-o", out, "--force", "--quiet"])
    edits = json.loads((out / "summary.json").read_text())["edits"]
    say(f"  {title}: {edits['edit_wall_s']:.2f} s for {len(edits['list'])} edits")
    return {
        "title": title,
        "nodes": summary["graph_nodes"],
        "closures": summary["loop_closures_accepted"],
        "open_s": edits["open_wall_s"],
        "delete_s": seconds_of(edits, "delete_closure"),
        "add_s": seconds_of(edits, "add_closure"),
        "ignore_s": seconds_of(edits, "ignore"),
        "draw_s": edits["draw_wall_s"],
    }


def text_of(section):
    rows = [
        [
            row["title"],
            str(row["nodes"]),
            str(row["closures"]),
            f"{row['open_s']:.2f}",
            f"{1e3 * row['delete_s']:.0f}",
            f"{1e3 * row['add_s']:.0f}",
            f"{1e3 * row['ignore_s']:.0f}",
            f"{row['draw_s']:.2f}",
        ]
        for row in section["figures"]
    ]
    header = [
        "map",
        "nodes>",
        "closures>",
        "to open [s]>",
        "delete_closure [ms]>",
        "add_closure [ms]>",
        "ignore, 5 s [ms]>",
        "to draw [s]>",
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
            f"{row['title']}: the longest of these edits, median of {EDITS}",
            f"<= {TARGET_EDIT_S:g} s",
            f"{max(row['delete_s'], row['add_s'], row['ignore_s']):.3f} s",
            max(row["delete_s"], row["add_s"], row["ignore_s"]) <= TARGET_EDIT_S,
        )
        for row in rows
    ]


def main():
    arguments = plain_parser(__doc__, ROOT).parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    section = circumstances(loopstone.version())
    rows = []
    intel = arguments.data / "carmen/intel.clf"
    if intel.exists():
        rows.append(measure(loopstone, "Intel, 180 beams", intel, "intel"))
    if not arguments.quick:
        campus = loopstone.simulate("campus", 1, ["--beams", "361"])
        rows.append(measure(loopstone, "simulated campus, 361 beams", log_of(campus), "campus"))
    if not rows:
        return
    section["figures"] = rows
    (arguments.work / "editing.json").write_text(json.dumps(section, indent=1))
    text = text_of(section)
    if arguments.quick:
        print(text)
    elif write_block(ROOT / PAGE, BLOCK, text):
        say(f"wrote {PAGE}: {BLOCK}")
    print(verdicts(targets_of(rows)))


if __name__ == "__main__":
    main()
