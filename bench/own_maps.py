#!/usr/bin/env python3
"""Measures localisation from nowhere on maps that the mapper itself drew, of recorded and of
simulated logs, and writes the table of docs/accuracy.md.

Recorded logs are looked for in $LOOPSTONE_DATA, else in ../shared/data. Maps and simulations are
kept in build/bench/own_maps; what was measured in build/bench/own_maps.json.

  bench/own_maps.py                 everything (about 25 minutes on one core)
  bench/own_maps.py --kinds own day some of own, day, published, bare, other; writes nothing
  bench/own_maps.py --write         no measurement: the table from what is kept
"""
import argparse
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from confidence_tables import calibration_error, reliability  # noqa: E402
from doc_blocks import table, write_block  # noqa: E402
from own_maps_measure import OwnMaps, figures_of  # noqa: E402
from program import Loopstone  # noqa: E402
from provenance import circumstances, provenance  # noqa: E402
from recorded import data_folder  # noqa: E402

PAGE, BLOCK = ROOT / "docs/accuracy.md", "localization-own-maps"
# Other drives than those that the probability was fitted to (bench/confidence.py).
FIRST_SEED = 401
TITLES = {
    "own": "the log on its own map",
    "day": "second half on the map of the first; simulated: furniture moved between two laps",
    "published": "a map drawn by others",
    "bare": "bare corridors, on their map, from a known start",
    "other": "another building's map",
}
COLUMNS = [
    "drive",
    "scans>",
    "right [%]>",
    "TRACKING [%]>",
    "of known places [%]>",
    "wrong while TRACKING [%]>",
    "changes of state in 100 m>",
    "NEES, position>",
    "NEES, heading>",
    "CPU [ms a scan]>",
]


def line_of(title, f):
    number = lambda value, digits: "-" if value is None else f"{value:.{digits}f}"  # noqa: E731
    known = f["tracking_known"]
    return [
        title,
        f"{f['scans']:,}",
        number(100.0 * f["right"], 2),
        number(100.0 * f["tracking"], 2),
        number(None if known is None or f["known"] > 0.999 else 100.0 * known, 2),
        number(100.0 * f["wrong"], 3),
        number(f["changes_100m"], 1),
        number(f["nees_xy"], 2),
        number(f["nees_yaw"], 2),
        number(f["ms_per_scan"], 2),
    ]


def mean_of(figures):
    """Each drive counts the same."""
    means = {"scans": sum(f["scans"] for f in figures)}
    for key in figures[0]:
        values = [f[key] for f in figures if f[key] is not None]
        if key != "scans":
            means[key] = sum(values) / len(values) if values else None
    return means


def text_of(kept):
    by_kind = {}
    for drive in kept["drives"]:
        by_kind.setdefault(drive["kind"], []).append(drive)
    lines = []
    for kind, drives in by_kind.items():
        figures = [drive["figures"] for drive in drives]
        lines.append(line_of(f"**{TITLES[kind]}** ({len(drives)} drives)", mean_of(figures)))
        named = drives if kind != "other" else []
        lines += [line_of(drive["name"], drive["figures"]) for drive in named]
    bins = kept["reliability"]
    shares = [
        [
            f"{i / 10:.1f} to {(i + 1) / 10:.1f}",
            f"{b['scans']:,}",
            f"{b['stated']:.3f}",
            f"{b['right']:.3f}",
        ]
        for i, b in enumerate(bins)
        if b["scans"]
    ]
    return "\n\n".join(
        [
            provenance(kept),
            table(COLUMNS, lines),
            "The probability on all of these drives that the robot's own building is the map of:"
            f" calibration error {calibration_error(bins):.4f}.",
            table(["stated probability", "scans>", "its mean>", "share right>"], shares),
        ]
    )


def measured(arguments):
    work = arguments.work / "own_maps"
    work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.program, work)
    kept = {**circumstances(loopstone.version()), "drives": []}
    pairs = []
    for drive in OwnMaps(loopstone, arguments.data, FIRST_SEED).drives(arguments.kinds):
        kept["drives"].append(
            {"kind": drive.kind, "name": drive.name, "figures": figures_of(drive)}
        )
        if drive.kind != "other":
            pairs += [(row["probability"], row["right"] > 0.5) for row in drive.rows]
    kept["reliability"] = reliability(pairs)
    return kept


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--program", default=ROOT / "build/release/bin/loopstone")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/bench")
    parser.add_argument("--data", type=pathlib.Path, default=data_folder(ROOT))
    parser.add_argument("--kinds", nargs="+", choices=list(TITLES), default=None)
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    path = arguments.work / "own_maps.json"
    kept = json.loads(path.read_text()) if arguments.write else measured(arguments)
    if arguments.kinds:
        print(text_of(kept))
        return
    path.write_text(json.dumps(kept, indent=1))
    write_block(PAGE, BLOCK, text_of(kept))


if __name__ == "__main__":
    main()
