#!/usr/bin/env python3
"""Compares the noise of simulated logs with that of recorded ones: how far returns lie from the
surfaces of the map that the log itself gives, what share of them lies nowhere near a surface, what
share of beams does not come back. Writes a table of docs/simulation.md.

  bench/residuals.py                  everything (some minutes)
  bench/residuals.py --quick          a minute of the simulated drives; writes nothing into docs/
"""
import json
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from doc_blocks import table, write_block  # noqa: E402
from program import Failed, Loopstone, run, say  # noqa: E402
from provenance import circumstances, provenance  # noqa: E402
from sections import plain_parser  # noqa: E402

PAGE = ROOT / "docs/simulation.md"
RECORDED = {
    "carmen/intel.clf": "Intel, SICK LMS",
    "carmen/aces.clf": "ACES, SICK LMS",
    "carmen/mit-csail.clf": "MIT CSAIL, SICK LMS",
    "bags/trace0.bag": "Pioneer 3DX, Hokuyo",
    "bags/office_col.bag": "office, Hokuyo URG",
    "bags/office_2019.bag": "office 2019, Hokuyo URG",
    "rawlog/driving_in_office.rawlog": "Pioneer, SICK LMS",
}
HALF = ["--format", "carmen", "--beams", "181", "--fov", "180"]
SIMULATED = {
    "clean": [*HALF],
    "clean, ten people": [*HALF, "--people", "10"],
    "range": [*HALF, "--realism", "range"],
    "range,mixed,dropouts,steps": [*HALF, "--realism", "range,mixed,dropouts,steps"],
    "usual": [*HALF, "--realism", "usual"],
}
WORLDS = ["office", "rooms"]


def residuals(programs, log):
    return json.loads(run([programs / "measure_residuals", log, 1])[0])


def measured(arguments):
    rows = []
    for path, title in RECORDED.items():
        log = arguments.data / path
        if not log.exists():
            say(f"  {log}: not there")
            continue
        try:
            rows.append({"log": title, "kind": "recorded", **residuals(arguments.programs, log)})
            say(f"  {title}: {rows[-1]}")
        except Failed as failure:
            say(f"  {title}: {failure}")
    for world in WORLDS:
        for name, flags in SIMULATED.items():
            folder = arguments.work / f"sim-residuals-{world}"
            duration = 60 if arguments.quick else 240
            words = [arguments.programs / "loopstone", "simulate", world, "-o", folder]
            run([*words, "--seed", 1, "--duration", duration, *flags, "--force", "--quiet"])
            figures = residuals(arguments.programs, folder / "log.clf")
            rows.append({"log": f"{world}, {name}", "kind": "simulated", **figures})
            say(f"  {world}, {name}: {figures}")
            shutil.rmtree(folder)
    return rows


def percent(value):
    return f"{100 * value:.1f}"


def millimetres(value):
    return f"{1000 * value:.1f}" if value > 0 else ""


def residual_table(rows):
    cells = [
        [
            row["kind"],
            row["log"],
            str(row["scans"]),
            millimetres(row["repeat_m"]) if row["repeats"] > 1000 else "",
            millimetres(row["spread_m"]),
            millimetres(row["spread_near_m"]),
            millimetres(row["spread_far_m"]),
            percent(row["outlier_share"]),
            percent(row["lone_share"]),
            percent(row["bad_share"]),
            percent(row["no_return_share"]),
        ]
        for row in rows
    ]
    header = [
        "",
        "log",
        "scans>",
        "same beam, standing [mm]>",
        "about surfaces [mm]>",
        "within 5 m [mm]>",
        "beyond 10 m [mm]>",
        "off by 5 cm [%]>",
        "where nothing else is [%]>",
        "bad beams [%]>",
        "no return [%]>",
    ]
    return table(header, cells)


def main():
    arguments = plain_parser(__doc__, ROOT).parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    kept = arguments.work / f"residuals{'-quick' if arguments.quick else ''}.json"
    when = circumstances(loopstone.version())
    rows = measured(arguments)
    kept.write_text(json.dumps({**when, "figures": rows}, indent=1))
    text = provenance(when) + "\n\n" + residual_table(rows)
    print(text)
    if not arguments.quick:
        write_block(PAGE, "simulation-residuals", text)


if __name__ == "__main__":
    try:
        main()
    except subprocess.SubprocessError as failure:
        sys.exit(str(failure))
