#!/usr/bin/env python3
"""Holds the verdict on maps against the truth: simulated runs, as they are and spoiled on purpose,
and what the verdict said.

Writes the tables of docs/quality.md. What was measured is kept in build/bench/quality.json;
--resume goes on from there. The limits were chosen on the seeds called "chosen on"; the table of
the seeds called "checked on" is the one that counts.

  bench/quality.py                          everything (about ten minutes on a quiet machine)
  bench/quality.py --quick                  one seed of each kind; prints the tables, writes nothing
                                            into docs/
  bench/quality.py --worlds office campus   some worlds
  bench/quality.py --only                   no run: the tables from quality.json again
"""
import argparse
import json
import pathlib
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import quality_tables  # noqa: E402
from largest_error import largest_error  # noqa: E402
from doc_blocks import write_block  # noqa: E402
from program import Failed, Loopstone, log_of, say  # noqa: E402
from provenance import circumstances  # noqa: E402
from recorded import data_folder  # noqa: E402

CHOSEN_ON, CHECKED_ON = [1, 2], [31, 32, 33]
SICK = ["--format", "carmen", "--beams", "180", "--fov", "179"]
WIDE = ["--format", "carmen"]
UNKIND = [*SICK[:2], "--beams", "181", "--fov", "180", "--scan-rate", "5", "--duration", "480"]
BAD_WHEELS = [
    "--set",
    "wheels.imbalance=0.003",
    "--set",
    "wheels.turn_slip=0.05",
    "--set",
    "wheels.scale_error=0.06",
]
# name, world, flags of simulate, how many seeds of each kind at most
WORLDS = [
    ("office", "office", SICK, 3),
    ("office, 1081 beams", "office", WIDE, 1),
    ("office, people, bad wheels", "office", [*SICK, "--people", "10", *BAD_WHEELS], 1),
    ("campus", "campus", [*SICK, "--scan-rate", "5"], 1),
    ("rooms", "rooms", SICK, 2),
    ("warehouse", "warehouse", [*SICK, "--max-range", "80"], 2),
    ("corridor", "corridor", SICK, 1),
    *(
        (f"{world}, {effects}", world, [*UNKIND, "--realism", effects], 1)
        for world, effects in [
            ("office", "usual"),
            ("office", "usual,blocked"),
            ("office", "usual,crowd"),
            ("loops", "usual"),
            ("loops", "usual,ahead"),
            ("wings", "usual"),
            ("wings", "usual,blocked"),
            ("warehouse", "usual"),
            ("warehouse", "usual,standers"),
            ("aisles", "usual"),
            ("rooms", "usual,carried_blind"),
            ("hall", "usual"),
            ("outdoors", "usual"),
            ("outdoors", "usual,upside_down"),
            ("campus", "usual"),
        ]
    ),
    *((f"{world}, clean", world, UNKIND, 1) for world in ["loops", "wings", "aisles", "outdoors"]),
]
# Tried with these spoils alone: unkind worlds spoil by themselves.
UNKIND_SPOILS = ["as it is", "no loop closing", "gullible closures"]
# How a run is spoiled: name, flags of map.
SPOILS = [
    ("as it is", []),
    ("no loop closing", ["--no-loop-closure", "--set", "adjustment.enabled=false"]),
    ("no loop closing, adjusted", ["--no-loop-closure"]),
    ("scan to scan", ["--pipeline", "scan_to_scan"]),
    (
        "few closures",
        [
            "--set",
            "loop.candidates_max=1",
            "--set",
            "loop.drift_per_m=0.001",
            "--set",
            "loop.drift_rad_per_m=0.0002",
            "--set",
            "loop.min_overlap=0.9",
        ],
    ),
    (
        "gullible closures",
        [
            "--set",
            "loop.min_score=0.05",
            "--set",
            "loop.min_overlap=0.05",
            "--set",
            "loop.min_agreement=0.2",
            "--set",
            "loop.max_ambiguity=1.0",
            "--set",
            "loop.drift_per_m=0.3",
        ],
    ),
    ("blunt matching", ["--set", "submap.cell_m=0.3", "--set", "match.kernel_width_m=0.2"]),
    (
        "hasty matching",
        [
            "--set",
            "match.max_iterations=2",
            "--set",
            "front_end.points_max=60",
            "--set",
            "front_end.trusted_score=0.0",
        ],
    ),
]


def run_of(loopstone, case, seed, spoil):
    name, world, sim_flags, _ = case
    sim = loopstone.simulate(world, seed, sim_flags)
    folder, summary, _ = loopstone.map(log_of(sim), "quality", [*spoil[1], "--threads", "1"])
    errors = loopstone.evaluate(
        "--estimate",
        folder / "trajectory.tum",
        "--reference",
        sim / "truth.tum",
        "--map",
        folder / "map.yaml",
        "--true-map",
        sim / "map.yaml",
    )
    quality = summary["quality"]
    worst_m, worst_deg = largest_error(folder / "trajectory.tum", sim / "truth.tum")
    return {
        "world": name,
        "seed": seed,
        "spoil": spoil[0],
        "ate_m": errors["ate_rmse_m"],
        "max_m": worst_m,
        "max_deg": worst_deg,
        "f1": errors["map"]["f1"],
        "quality": quality,
        "judging_s": summary["judging_wall_s"],
        "wall_s": summary["wall_time_s"],
        "path_m": summary["path_length_m"],
    }


def recorded_runs(loopstone, data):
    """Recorded logs, whose truth is not known: with loop closing and without. No limit was chosen
    on them."""
    runs = []
    for name, title in [
        ("intel", "Intel Research Lab"),
        ("aces", "ACES building"),
        ("mit-csail", "MIT CSAIL"),
    ]:
        log = data / "carmen" / f"{name}.clf"
        for spoil in SPOILS[:2] if log.exists() else []:
            _, summary, _ = loopstone.map(log, "quality", [*spoil[1], "--threads", "1"])
            runs.append({"log": title, "spoil": spoil[0], "quality": summary["quality"]})
            say(f"  {title}, {spoil[0]}: {summary['quality']['verdict']}")
    return runs


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/loopstone"))
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/bench")
    parser.add_argument("--data", type=pathlib.Path, default=data_folder(ROOT))
    parser.add_argument("--worlds", nargs="*", choices=sorted({case[1] for case in WORLDS}))
    parser.add_argument("--only", nargs="*", choices=["runs"], default=["runs"])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--resume", action="store_true", help="leave out what has been run")
    arguments = parser.parse_args()

    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.program, arguments.work)
    kept = arguments.work / ("quality-quick.json" if arguments.quick else "quality.json")
    record = {"sessions": [], "runs": []}
    if kept.exists() and (arguments.resume or not arguments.only):
        record = json.loads(kept.read_text())
    if arguments.only:
        record["sessions"].append(circumstances(loopstone.version()))
    done = {(run["world"], run["seed"], run["spoil"]) for run in record["runs"]}
    for case in WORLDS if arguments.only else []:
        if arguments.worlds and case[1] not in arguments.worlds:
            continue
        most = 1 if arguments.quick else case[3]
        for seed in [*CHOSEN_ON[:most], *CHECKED_ON[:most]]:
            for spoil in SPOILS:
                if (case[0], seed, spoil[0]) in done:
                    continue
                if case[2][: len(UNKIND)] == UNKIND and spoil[0] not in UNKIND_SPOILS:
                    continue
                try:
                    run = run_of(loopstone, case, seed, spoil)
                except Failed as failure:
                    say(f"  {case[0]} {seed}, {spoil[0]}: FAILED\n{failure}")
                    continue
                say(
                    f"  {case[0]} {seed}, {spoil[0]}: off by {run['max_m']:.2f} m,"
                    f" {run['max_deg']:.1f} deg at most,"
                    f" {run['quality']['verdict']}"
                )
                record["runs"].append(run)
                kept.write_text(json.dumps(record, indent=1))
            shutil.rmtree(loopstone.simulate(case[1], seed, case[2]), ignore_errors=True)

    if arguments.only and not arguments.worlds:
        record["recorded"] = recorded_runs(loopstone, arguments.data) or record.get("recorded", [])
        kept.write_text(json.dumps(record, indent=1))
    blocks = quality_tables.blocks_of(record, CHOSEN_ON, CHECKED_ON)
    for block, text in blocks:
        if arguments.quick or arguments.worlds:
            print(f"\n{block}\n{text}")
        else:
            write_block(ROOT / "docs/quality.md", block, text)
    print(quality_tables.headline(record, CHECKED_ON))


if __name__ == "__main__":
    main()
