#!/usr/bin/env python3
"""Measures what saving a run costs, kills runs at random moments, and writes the table of
docs/session.md.

Recorded logs are looked for in $LOOPSTONE_DATA, else in ../shared/data; without them only the
simulated one is measured.

  bench/session.py            everything (about five minutes)
  bench/session.py --quick    fewer kills; prints the table, writes nothing into docs/
"""
import json
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from doc_blocks import table, write_block  # noqa: E402
from program import Loopstone, median, say  # noqa: E402
from sections import plain_parser  # noqa: E402
from provenance import circumstances, provenance  # noqa: E402

PAGE, BLOCK = ROOT / "docs/session.md", "session-cost"
SAVED = re.compile(
    r"session saved (\d+) times, ([\d.]+) MB at last; scans waited for it ([\d.]+) ms each time,"
    r" ([\d.]+) ms"
)
RESULTS = ["trajectory.tum", "odometry.tum", "graph.g2o", "loop_closures.csv", "map.pgm", "map.png"]
NOT_OF_THE_RESULT = re.compile(
    r"_wall_s$|^(wall_time_s|cpu_time_s|realtime_factor|scans_per_s|peak_memory_bytes|threads"
    r"|command|realtime)$"
)
REPEATS = 3


def result_of(folder):
    """The bytes of a result, without times."""
    summary = json.loads((folder / "summary.json").read_text())
    rest = {key: value for key, value in summary.items() if not NOT_OF_THE_RESULT.search(key)}
    return [(folder / name).read_bytes() for name in RESULTS] + [rest]


def map_log(loopstone, log, folder, *flags):
    """A whole run in an empty folder: what it said and what it took."""
    shutil.rmtree(folder, ignore_errors=True)
    command = [
        str(word) for word in [loopstone.program, "map", log, "-o", folder, "--no-texture", *flags]
    ]
    started = time.monotonic()
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=True)
    return done.stderr.decode(), time.monotonic() - started


def killed_run(loopstone, log, folder, wall_s, interval_s, rng):
    """Kills the run at random moments until it has ended; the number of kills."""
    shutil.rmtree(folder, ignore_errors=True)
    command = [
        str(word)
        for word in [
            loopstone.program,
            "map",
            log,
            "-o",
            folder,
            "--no-texture",
            "--quiet",
            "--checkpoint",
            interval_s,
            "--resume",
        ]
    ]
    kills = 0
    while True:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        try:
            code = process.wait(timeout=rng.uniform(0.1 * wall_s, wall_s))
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
            kills += 1
            continue
        if code != 0:
            raise SystemExit(f"{' '.join(command)}\nended with {code} after {kills} kills")
        return kills


def measure(loopstone, name, log, least_kills):
    say(f"{name}:")
    whole, saved = loopstone.work / "session-whole", loopstone.work / "session-saved"
    plain_s = median([map_log(loopstone, log, whole)[1] for _ in range(REPEATS)])
    expected = result_of(whole)
    interval_s = round(plain_s / 20, 2)
    rounds = [map_log(loopstone, log, saved, "--checkpoint", interval_s) for _ in range(REPEATS)]
    figures = [list(map(float, SAVED.search(said).groups())) for said, _ in rounds]
    row = {
        "name": name,
        "scans": expected[-1]["scans"],
        "plain_s": plain_s,
        "interval_s": interval_s,
        "saved_s": median([wall_s for _, wall_s in rounds]),
        "megabytes": figures[-1][1],
        "times": median([f[0] for f in figures]),
        "mean_ms": median([f[2] for f in figures]),
        "worst_ms": max(f[3] for f in figures),
        "same": result_of(saved) == expected,
        "kills": 0,
        "runs": 0,
    }
    rng = random.Random(1)
    while row["kills"] < least_kills:
        row["kills"] += killed_run(loopstone, log, saved, plain_s, interval_s, rng)
        row["runs"] += 1
        row["same"] = row["same"] and result_of(saved) == expected
    say(f"  {row}")
    return row


def text_of(when, rows):
    cells = [
        [
            row["name"],
            str(row["scans"]),
            f"{row['megabytes']:.1f}",
            f"{row['mean_ms']:.1f}",
            f"{row['worst_ms']:.1f}",
            f"{row['plain_s']:.2f}",
            f"{row['saved_s']:.2f}",
            str(row["kills"]),
            str(row["runs"]),
            "same bytes" if row["same"] else "DIFFERENT",
        ]
        for row in rows
    ]
    return "\n".join(
        [
            provenance(when),
            "",
            table(
                [
                    "log",
                    "scans>",
                    "session at the end [MB]>",
                    "scans wait [ms]>",
                    "at most [ms]>",
                    "run [s]>",
                    "saving every 20th of it [s]>",
                    "kills>",
                    "runs>",
                    "results",
                ],
                cells,
            ),
        ]
    )


def main():
    parser = plain_parser(__doc__, ROOT)
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    when = circumstances(loopstone.version())
    least_kills = 5 if arguments.quick else 20
    rows = []
    intel = arguments.data / "carmen/intel.clf"
    if intel.exists():
        rows.append(measure(loopstone, "Intel, 180 beams", intel, least_kills))
    office = loopstone.simulate("office", 1, ["--beams", "1081"])
    rows.append(measure(loopstone, "office, 1081 beams", office, least_kills))
    text = text_of(when, rows)
    if arguments.quick:
        print(text)
    else:
        write_block(PAGE, BLOCK, text)
    return 0 if all(row["same"] for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
