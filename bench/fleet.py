#!/usr/bin/env python3
"""Maps 1,000 simulated logs of many robots with loopstone-fleet by two workers, the first 100 of
them by one and by two, and tells what a log costs, whether every log ends with one row, and by
these costs what a million logs take. Writes the table of docs/fleet.md.

  bench/fleet.py               an hour on two slow processors, of which a quarter simulates
  bench/fleet.py --quick       20 logs; writes nothing into docs/
  bench/fleet.py --logs 200    likewise
  bench/fleet.py --speed       that of one worker and of two anew, after a full run (ten minutes)
  bench/fleet.py --write       no run: the table from what the last full run measured

It needs build/fleet/venv (scripts/test_fleet.sh). One log in a hundred is no log at all. What was
measured is kept in build/bench/fleet.json, of other runs in fleet-some.json.
"""
import collections
import concurrent.futures
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import fleet_tables  # noqa: E402
from doc_blocks import write_block  # noqa: E402
from program import Loopstone, run, say  # noqa: E402
from provenance import circumstances  # noqa: E402
from sections import plain_parser, verdicts  # noqa: E402

PAGE, BLOCK = "docs/fleet.md", "fleet"
LOGS, QUICK_LOGS = 1000, 20
SCALED_LOGS = 100  # that one worker maps, too
DURATION_S = 60
FLAGS = "--format carmen --beams 181 --fov 180 --scan-rate 5 --realism usual --quiet".split()
WORLDS = ["office", "rooms", "warehouse", "loops"]
FIRST_DAY_S, DAY_S = 1767225600, 86400  # 2026
# Drives in the same world are of one site, each of another day.
DRIVES_A_SITE, ROBOTS, BROKEN_EVERY = 10, 50, 100
FEW = 5  # logs of a run that tells what a run costs by itself
LINES = 100_000  # of a manifest that is read and refused for its last line


def simulate(program, folder, number):
    """The path of log `number`, which is made unless it is there."""
    site = number // DRIVES_A_SITE
    path = folder / f"site-{site:04}" / f"{number:06}.clf"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        if number % BROKEN_EVERY == BROKEN_EVERY - 1:
            path.write_text(f"not log {number}\n")
            return path
        sim = folder / f"sim-{number}"
        command = [program, "simulate", WORLDS[site % len(WORLDS)], "-o", sim, *FLAGS, "--force"]
        begins_s = FIRST_DAY_S + DAY_S * (number % DRIVES_A_SITE)
        command += ["--duration", str(DURATION_S), "--set", f"start_s={begins_s}"]
        command += ["--seed", str(1 + site)]
        subprocess.run([*command, "--drive-seed", str(1 + number)], check=True, capture_output=True)
        os.replace(sim / "log.clf", path)
        shutil.rmtree(sim)
    return path


def write_manifest(path, logs):
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["log", "robot", "site"])
        for number, log in enumerate(logs):
            writer.writerow([log, f"robot-{number % ROBOTS:03}", log.parent.name])


def rows_of(out):
    """All rows, and how many logs have exactly one."""
    rows = [json.loads(path.read_bytes()) for path in (out / "rows").rglob("*.json")]
    logs = collections.Counter(row["log"] for row in rows)
    return rows, sum(count == 1 for count in logs.values())


class Fleet:
    """The command, with the program that it runs."""

    def __init__(self, program):
        self.command = ROOT / "build/fleet/venv/bin/loopstone-fleet"
        self.program = program
        if not self.command.exists():
            raise SystemExit(f"{self.command}: not there; scripts/test_fleet.sh makes it")

    def run(self, manifest, out, workers, check=True):
        """What a run took, as a whole."""
        words = ["run", manifest, "-o", out, "--workers", workers, "--quiet"]
        return run([self.command, *words, "--program", self.program], check)[1]

    def report(self, out):
        return run([self.command, "report", out])[1]


def run_anew(fleet, manifest, logs, out, workers):
    """Figures of one run from nothing over so many logs."""
    shutil.rmtree(out, ignore_errors=True)
    cost = fleet.run(manifest, out, workers)
    rows, logs_with_one_row = rows_of(out)
    done = [row for row in rows if row["status"] == "done"]
    results = [path for path in (out / "results").rglob("*") if path.is_file()]
    joins = [row["site_wall_s"] for row in rows if "site_wall_s" in row]
    return {
        "workers": workers,
        "logs": logs,
        "wall_s": cost["wall_s"],
        "coordinator_peak_mb": cost["peak_mb"],
        "one_row": logs_with_one_row,
        "statuses": dict(collections.Counter(row["status"] for row in rows)),
        "process_wall_s": sum(row.get("process_wall_s", 0) for row in rows),
        "process_cpu_s": sum(row.get("process_cpu_s", 0) for row in rows),
        "recorded_s": sum(row["duration_s"] for row in done),
        "log_bytes": sum(row.get("log_bytes", 0) for row in rows),
        "peak_mb": max(row["process_peak_memory_bytes"] for row in done) / 1e6,
        "result_bytes": sum(path.stat().st_size for path in results),
        "result_files": len(results),
        "row_bytes": sum(path.stat().st_size for path in (out / "rows").rglob("*.json")),
        "table_bytes": (out / "fleet.parquet").stat().st_size,
        "page_bytes": (out / "fleet.html").stat().st_size,
        "joins": len(joins),
        "join_wall_s": sum(joins),
    }


def logs_of(fleet, work, count):
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        folder = work / "fleet-logs"
        return list(pool.map(lambda number: simulate(fleet.program, folder, number), range(count)))


def measure_speed(fleet, work, logs):
    """The first logs by one worker, and by two."""
    scaled = logs[:SCALED_LOGS]
    manifest = work / "fleet-scaled.csv"
    write_manifest(manifest, scaled)
    for log in scaled:  # as warm for the first as for the second
        log.read_bytes()
    runs = []
    for workers in (1, 2):
        say(f"  {len(scaled)} logs, {workers} at a time")
        runs.append(run_anew(fleet, manifest, len(scaled), work / "fleet-out", workers))
    shutil.rmtree(work / "fleet-out")
    return runs


def measure(fleet, work, count):
    logs = logs_of(fleet, work, count)
    manifest, few, out = work / "fleet.csv", work / "fleet-few.csv", work / "fleet-out"
    write_manifest(manifest, logs)
    write_manifest(few, logs[:FEW])
    runs = measure_speed(fleet, work, logs)
    say(f"  {count} logs, 2 at a time")
    runs.append(run_anew(fleet, manifest, count, out, 2))
    few_out = work / "fleet-few-out"
    run_anew(fleet, few, len(logs[:FEW]), few_out, 2)
    figures = {
        "again_s": fleet.run(manifest, out, 2)["wall_s"] - fleet.run(few, few_out, 2)["wall_s"],
        "report_s": fleet.report(out)["wall_s"] - fleet.report(few_out)["wall_s"],
        "more_logs": count - len(logs[:FEW]),
        "line_bytes": memory_of_a_line(fleet, work),
    }
    shutil.rmtree(out)
    shutil.rmtree(few_out)
    return {"logs": count, "runs": runs, **figures}


def memory_of_a_line(fleet, work):
    """What loopstone-fleet keeps for each line of a manifest."""
    peaks = []
    path, out = work / "fleet-long.csv", work / "fleet-none"
    for lines in (1, LINES):
        logs = [work / "fleet-logs" / "site-0000" / f"{number:06}.clf" for number in range(lines)]
        write_manifest(path, [*logs, logs[0]])  # one of them twice
        peaks.append(fleet.run(manifest=path, out=out, workers=1, check=False)["peak_mb"])
    path.unlink()
    return 1e6 * (peaks[1] - peaks[0]) / (LINES - 1)


def main():
    parser = plain_parser(__doc__, ROOT)
    parser.add_argument("--logs", type=int, help=f"how many (default: {LOGS})")
    parser.add_argument("--speed", action="store_true", help="of one worker and two, anew")
    parser.add_argument("--write", action="store_true", help="the table again")
    arguments = parser.parse_args()
    count = arguments.logs or (QUICK_LOGS if arguments.quick else LOGS)
    is_full = count == LOGS
    arguments.work.mkdir(parents=True, exist_ok=True)
    kept = arguments.work / f"fleet{'' if is_full else '-some'}.json"
    if arguments.write:
        section = json.loads(kept.read_text())
    else:
        loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
        fleet = Fleet(loopstone.program)
        now = circumstances(loopstone.version())
        if arguments.speed:
            section = {**json.loads(kept.read_text()), "speed": now}
            logs = logs_of(fleet, arguments.work, count)
            section["figures"]["runs"][:2] = measure_speed(fleet, arguments.work, logs)
        else:
            section = {**now, "figures": measure(fleet, arguments.work, count)}
        kept.write_text(json.dumps(section, indent=1))
    text = fleet_tables.text_of(section)
    if not is_full:
        print(text)
    elif write_block(ROOT / PAGE, BLOCK, text):
        say(f"wrote {PAGE}: {BLOCK}")
    print(verdicts(fleet_tables.targets_of(section["figures"])))


if __name__ == "__main__":
    main()
