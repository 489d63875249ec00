#!/usr/bin/env python3
"""Measures how mapping fares when things go wrong, and writes the tables of docs/robustness.md:
faults of odometry on simulated worlds, whether and when they were noticed, honest odometry that
must not be accused, lost scans, people and glass, and recorded logs mapped from the laser alone.

What was measured is kept in build/bench/robustness.json, so a later run of one section leaves the
others standing.

  bench/robustness.py                    everything (about a quarter of an hour)
  bench/robustness.py --quick            fewer seeds; to look at, writes nothing into docs/
  bench/robustness.py --only recorded    some sections
  bench/robustness.py --only             no measurement: writes the tables from robustness.json
                                         again
"""
import argparse
import json
import math
import pathlib
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from doc_blocks import table, write_block  # noqa: E402
from program import Loopstone, median, say  # noqa: E402
from provenance import circumstances, provenance  # noqa: E402
from recorded import data_folder  # noqa: E402

SECTIONS = ["faults", "honest", "surroundings", "recorded"]
FAULTS = ["none", "missing", "stuck", "scaled", "mirrored", "lagging", "jumping"]
WORLDS = ["office", "rooms", "warehouse"]
DURATION_S = 150
# What the simulated robot logs: counts and gyro, 270 degrees; or half a circle of few beams and its
# own dead reckoning.
ROBOTS = {
    "wheels and gyro": ["--beams", "541"],
    "dead reckoning": ["--format", "carmen", "--beams", "181", "--fov", "180"],
}
SURROUNDINGS = {
    "none": [],
    "a third of the scans lost": ["--set", "faults.scans_dropped=0.33"],
    "a fifth of the walls glass": ["--set", "faults.glass=0.2"],
    "ten people": ["--people", "10"],
    "all of these": [
        "--set",
        "faults.scans_dropped=0.33",
        "--set",
        "faults.glass=0.2",
        "--people",
        "10",
    ],
    "turns of 3 rad/s": ["--set", "drive.yaw_rate_rad_s=3", "--set", "drive.speed_m_s=1"],
}


def simulated(loopstone, world, seed, flags):
    """A log (its path), and the folder that also holds its truth."""
    folder = loopstone.simulate(world, seed, ["--duration", DURATION_S, *flags])
    log = folder / "log.clf"
    return (log if log.exists() else folder), folder


def travelled_m(truth, until_s):
    """Length of the true path from the first scan until a time after it."""
    length, start, before = 0.0, None, None
    for line in truth.read_text().splitlines():
        if line.startswith("#"):
            continue
        time_s, x, y = map(float, line.split()[:3])
        start = time_s if start is None else start
        if time_s - start > until_s:
            break
        if before:
            length += math.hypot(x - before[0], y - before[1])
        before = (x, y)
    return length


def mapped(loopstone, log, folder, flags=()):
    out, summary, _ = loopstone.map(log, "robustness", flags)
    error = loopstone.evaluate(
        "--estimate", out / "trajectory.tum", "--reference", folder / "truth.tum", "--align", "se2"
    )
    faults = summary["odometry_faults"]
    named = sorted({fault["fault"] for fault in faults})
    if any(warning.startswith("odometry jumped") for warning in summary["warnings"]):
        named.append("jumping")
    if any(warning.startswith("no odometry in the log") for warning in summary["warnings"]):
        named.append("missing")
    noticed_s = min((fault["noticed_s"] for fault in faults), default=None)
    return {
        "ate_m": error["ate_rmse_m"],
        "named": named,
        "warnings": summary["warnings"],
        "noticed_m": None if noticed_s is None else travelled_m(folder / "truth.tum", noticed_s),
        "searches": summary["searches"],
        "scans": summary["scans"],
    }


def measure_faults(loopstone, seeds):
    rows = []
    for robot, robot_flags in ROBOTS.items():
        for world in WORLDS:
            for fault in FAULTS:
                runs = []
                for seed in seeds:
                    log, folder = simulated(
                        loopstone, world, seed, [*robot_flags, "--odometry-fault", fault]
                    )
                    runs.append(mapped(loopstone, log, folder))
                    shutil.rmtree(folder)
                rows.append({"robot": robot, "world": world, "fault": fault, "runs": runs})
                say(
                    f"  {robot}, {world}, {fault}: {max(r['ate_m'] for r in runs):.4f} m,"
                    f" {[r['named'] for r in runs]}"
                )
    return rows


def measure_honest(loopstone, seeds):
    rows = []
    for robot, robot_flags in ROBOTS.items():
        for world in [*WORLDS, "campus", "corridor"]:
            accused = []
            for seed in seeds:
                log, folder = simulated(loopstone, world, 100 + seed, robot_flags)
                accused += mapped(loopstone, log, folder, ["--no-loop-closure"])["named"]
                shutil.rmtree(folder)
            rows.append({"robot": robot, "world": world, "runs": len(seeds), "accused": accused})
            say(f"  {robot}, {world}: {accused}")
    return rows


def measure_surroundings(loopstone, seeds):
    rows = []
    for name, flags in SURROUNDINGS.items():
        row = {"name": name, "with": [], "without": []}
        for seed in seeds:
            log, folder = simulated(loopstone, "office", seed, flags)
            row["with"].append(mapped(loopstone, log, folder)["ate_m"])
            row["without"].append(mapped(loopstone, log, folder, ["--odometry", "ignore"])["ate_m"])
            shutil.rmtree(folder)
        rows.append(row)
        say(f"  {name}: {row['with']} {row['without']}")
    return rows


def measure_recorded(loopstone, data):
    rows = []
    for name, title in (
        ("intel", "Intel Research Lab"),
        ("aces", "ACES building"),
        ("mit-csail", "MIT CSAIL"),
    ):
        log = data / f"carmen/{name}.clf"
        if not log.exists():
            say(f"  {log}: not there")
            continue
        relations = data / f"carmen/{name}.relations"
        trajectories = {}
        for odometry in ("check", "ignore"):
            out, summary, cost = loopstone.map(log, f"{name}-{odometry}", ["--odometry", odometry])
            trajectories[odometry] = out / "trajectory.tum"
            row = {
                "title": title,
                "odometry": odometry,
                "scans": summary["scans"],
                "searches": summary["searches"],
                "closures": summary["loop_closures_accepted"],
                "cpu_s": cost["cpu_s"],
                "front_end_us": 1e6 * summary["front_end_wall_s"] / summary["scans"],
                "faults": [fault["fault"] for fault in summary["odometry_faults"]],
                "jumps": (
                    summary["odometry_jumps"]
                    if any(w.startswith("odometry jumped") for w in summary["warnings"])
                    else 0
                ),
            }
            if relations.exists():
                error = loopstone.evaluate(
                    "--estimate", out / "trajectory.tum", "--relations", relations
                )
                row["translation_m"] = error["translation_error_m"]
                row["rotation_deg"] = error["rotation_error_deg"]
            rows.append(row)
        apart = loopstone.evaluate(
            "--estimate",
            trajectories["ignore"],
            "--reference",
            trajectories["check"],
            "--align",
            "se2",
        )
        rows[-1]["apart_m"] = apart["ate_rmse_m"]
        say(f"  {title}: {rows[-2:]}")
    return rows


def centimetres(values):
    return [f"{100 * median(values):.1f}", f"{100 * max(values):.1f}"]


def fault_table(rows):
    cells = []
    for row in rows:
        runs = row["runs"]
        expected = {
            "none": [],
            "stuck": ["stuck"],
            "scaled": ["scaled"],
            "mirrored": ["mirrored"],
            "lagging": ["lagging"],
            "jumping": ["jumping"],
            "missing": ["missing"],
        }[row["fault"]]
        right = sum(
            set(expected) <= set(run["named"]) if expected else not run["named"] for run in runs
        )
        others = sorted({name for run in runs for name in run["named"]} - set(expected))
        noticed = [run["noticed_m"] for run in runs if run["noticed_m"] is not None]
        cells.append(
            [
                row["robot"],
                row["world"],
                row["fault"],
                *centimetres([run["ate_m"] for run in runs]),
                f"{right} of {len(runs)}",
                ", ".join(others),
                f"{median(noticed):.1f}" if noticed else "",
            ]
        )
    return table(
        [
            "robot",
            "world",
            "fault",
            "ATE, median [cm]>",
            "ATE, largest [cm]>",
            "said rightly>",
            "also said",
            "noticed after [m]>",
        ],
        cells,
    )


def tables_of(sections):
    blocks = []
    if "faults" in sections:
        section = sections["faults"]
        blocks.append(("faults", provenance(section) + "\n\n" + fault_table(section["figures"])))
    if "honest" in sections:
        section = sections["honest"]
        cells = [
            [row["robot"], row["world"], str(row["runs"]), ", ".join(row["accused"]) or "none"]
            for row in section["figures"]
        ]
        blocks.append(
            (
                "honest",
                provenance(section)
                + "\n\n"
                + table(["robot", "world", "drives>", "accused of"], cells),
            )
        )
    if "surroundings" in sections:
        section = sections["surroundings"]
        cells = [
            [row["name"], *centimetres(row["with"]), *centimetres(row["without"])]
            for row in section["figures"]
        ]
        blocks.append(
            (
                "surroundings",
                provenance(section)
                + "\n\n"
                + table(
                    [
                        "what is wrong",
                        "ATE, median [cm]>",
                        "largest [cm]>",
                        "laser only: median [cm]>",
                        "largest [cm]>",
                    ],
                    cells,
                ),
            )
        )
    if "recorded" in sections:
        section = sections["recorded"]
        cells = []
        for row in section["figures"]:
            has_relations = "translation_m" in row
            cells.append(
                [
                    row["title"],
                    "laser only" if row["odometry"] == "ignore" else "with odometry",
                    (
                        f"{row['translation_m']['mean']:.3f} +- {row['translation_m']['std']:.3f}"
                        if has_relations
                        else ""
                    ),
                    (
                        f"{row['rotation_deg']['mean']:.2f} +- {row['rotation_deg']['std']:.2f}"
                        if has_relations
                        else ""
                    ),
                    f"{100 * row['apart_m']:.1f}" if "apart_m" in row else "",
                    str(row["closures"]),
                    str(row["searches"]),
                    ", ".join(row["faults"] + ([f"{row['jumps']} jumps"] if row["jumps"] else []))
                    or "nothing",
                    f"{row['front_end_us']:.0f}",
                ]
            )
        blocks.append(
            (
                "recorded",
                provenance(section)
                + "\n\n"
                + table(
                    [
                        "log",
                        "",
                        "relations [m]>",
                        "relations [deg]>",
                        "from the map with odometry [cm]>",
                        "loop closures>",
                        "searches>",
                        "odometry accused of",
                        "front end, wall [us a scan]>",
                    ],
                    cells,
                ),
            )
        )
    return blocks


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/loopstone"))
    parser.add_argument("--data", type=pathlib.Path, default=data_folder(ROOT))
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/bench")
    parser.add_argument("--only", nargs="*", choices=SECTIONS, default=SECTIONS)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()

    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.program, arguments.work)
    kept = arguments.work / ("robustness-quick.json" if arguments.quick else "robustness.json")
    sections = json.loads(kept.read_text()) if kept.exists() else {}
    seeds = range(1, 2 if arguments.quick else arguments.seeds + 1)
    for name in arguments.only:
        say(f"{name}:")
        section = circumstances(loopstone.version())
        if name == "recorded":
            section["figures"] = measure_recorded(loopstone, arguments.data)
        else:
            measures = {
                "faults": measure_faults,
                "honest": measure_honest,
                "surroundings": measure_surroundings,
            }
            section["figures"] = measures[name](loopstone, seeds)
        if section["figures"]:
            sections[name] = section
            kept.write_text(json.dumps(sections, indent=1))

    for name, text in tables_of(sections):
        if arguments.quick:
            print(f"\n{name}\n{text}")
        else:
            write_block(ROOT / "docs/robustness.md", f"robustness-{name}", text)


if __name__ == "__main__":
    main()
