"""What is measured: each function returns plain figures for one section of the tables."""
import json
import shutil

import corrected_logs
from peers import mrpt_slam
from program import Failed, median, run, say

UNADJUSTED = ["--set", "adjustment.enabled=false"]
PIPELINES = [
    ("scan to scan (baseline)", ["--pipeline", "scan_to_scan"]),
    ("Loopstone without loop closing", ["--no-loop-closure"]),
    ("Loopstone without the adjustment to surfaces", UNADJUSTED),
    ("Loopstone", []),
]


def map_row(loopstone, log, name, flags):
    folder, summary, cost = loopstone.map(log, name, flags)
    row = {
        **cost,
        "duration_s": summary["duration_s"],
        "closures": summary["loop_closures_accepted"],
        "scans": summary["scans"],
    }
    return folder, summary, row


def relations_of(loopstone, trajectory, relations):
    result = loopstone.evaluate("--estimate", trajectory, "--relations", relations)
    return {
        "translation_m": result["translation_error_m"],
        "rotation_deg": result["rotation_error_deg"],
        "pairs": result["pairs"],
        "pairs_missing": result["pairs_missing"],
    }


def real_logs(loopstone, data):
    """Relations error on recorded logs, for dead reckoning, the baseline and Loopstone; all with
    default options."""
    logs = []
    for name, title in [
        ("intel", "Intel Research Lab"),
        ("aces", "ACES building"),
        ("mit-csail", "MIT CSAIL"),
    ]:
        log = data / "carmen" / f"{name}.clf"
        relations = data / "carmen" / f"{name}.relations"
        if not log.exists():
            say(f"  {log}: not there, skipped")
            continue
        rows = []
        if relations.exists():
            odometry = relations_of(loopstone, loopstone.odometry(log), relations)
            rows.append({"system": "odometry alone", **odometry})
        for system, flags in PIPELINES if relations.exists() else PIPELINES[-1:]:
            say(f"  {title}: {system}")
            folder, summary, row = map_row(loopstone, log, name, flags)
            if relations.exists():
                row |= relations_of(loopstone, folder / "trajectory.tum", relations)
            rows.append({"system": system, **row})
            if not flags:
                loop = {
                    "rejected": summary["loop_closures_rejected"],
                    "area_m2": summary.get("map_area_m2"),
                }
        corrected = data / "carmen" / f"{name.split('-')[-1]}-corrected.log"
        if corrected.exists():
            reference = loopstone.work / "corrected.tum"
            found, count = corrected_logs.write_reference(reference, log, corrected)
            errors = loopstone.evaluate(
                "--estimate", folder / "trajectory.tum", "--reference", reference
            )
            loop["corrected"] = {
                "scans": found,
                "of": count,
                "ate_m": errors["ate_rmse_m"],
                "ate_rad": errors["ate_rmse_rad"],
            }
        logs.append({"name": name, "title": title, "rows": rows, **loop})
    return logs


def ate_of(loopstone, estimate, sim, folder=None):
    flags = ["--estimate", estimate, "--reference", sim / "truth.tum"]
    if folder is not None:
        flags += ["--map", folder / "map.yaml", "--true-map", sim / "map.yaml"]
    return loopstone.evaluate(*flags)


def simulated_run(loopstone, world, seed, flags, baseline):
    sim = loopstone.simulate(world, seed, flags)
    folder, summary, row = map_row(loopstone, sim, "sim", [])
    errors = ate_of(loopstone, folder / "trajectory.tum", sim, folder)
    row |= {
        "seed": seed,
        "ate_m": errors["ate_rmse_m"],
        "ate_rad": errors["ate_rmse_rad"],
        "max_m": errors["ate_translation_m"]["max"],
        "f1": errors["map"]["f1"],
        "path_m": summary["path_length_m"],
        "odometry_m": ate_of(loopstone, folder / "odometry.tum", sim)["ate_rmse_m"],
    }
    folder, _, _ = map_row(loopstone, sim, "unadjusted", UNADJUSTED)
    row["unadjusted_m"] = ate_of(loopstone, folder / "trajectory.tum", sim)["ate_rmse_m"]
    if baseline:
        folder, _, cost = map_row(loopstone, sim, "baseline", ["--pipeline", "scan_to_scan"])
        row |= {
            "baseline_m": ate_of(loopstone, folder / "trajectory.tum", sim)["ate_rmse_m"],
            "baseline_cpu_s": cost["cpu_s"],
        }
    return row


# What summary.json says about the time of the steps.
STAGES = (
    "front_end_wall_s",
    "loop_closing_wall_s",
    "optimisation_wall_s",
    "adjustment_wall_s",
    "rendering_wall_s",
    "judging_wall_s",
)
SICK = ["--beams", "180", "--fov", "179"]
CASES = [  # name, world, flags of simulate, seeds, seeds with --quick, seeds of the baseline
    ("office", "office", [], 10, 2, 3),
    ("office, 180 beams over 179 deg", "office", SICK, 3, 1, 1),
    ("office, 40 scans a second", "office", ["--scan-rate", "40"], 1, 1, 0),
    ("campus", "campus", [], 3, 1, 0),
    ("rooms", "rooms", [], 1, 1, 0),
    ("warehouse", "warehouse", [], 1, 1, 0),
    ("corridor", "corridor", [], 1, 1, 0),
]


def simulated(loopstone, quick):
    """Absolute trajectory error and map score where the truth is known."""
    cases = []
    for name, world, flags, seeds, few, baselines in CASES:
        case = {"name": name, "world": world, "flags": flags, "runs": []}
        for seed in range(1, (few if quick else seeds) + 1):
            try:
                run = simulated_run(loopstone, world, seed, flags, seed <= baselines)
            except Failed as failure:
                say(f"  {name} {seed}: FAILED\n{failure}")
                run = {"seed": seed, "failed": True}
            else:
                say(
                    f"  {name} {seed}: odometry {run['odometry_m']:.3f} m, Loopstone"
                    f" {run['ate_m']:.4f} m (unadjusted {run['unadjusted_m']:.4f} m),"
                    f" {run['cpu_s']:.1f} s CPU"
                )
            case["runs"].append(run)
        cases.append(case)
    return cases


def speed(loopstone, data, repeats):
    """The whole process on Intel, several times; the same log with one thread."""
    log = data / "carmen" / "intel.clf"
    if not log.exists():
        say(f"  {log}: not there, skipped")
        return None
    result = {"repeats": repeats, "variants": []}
    for name, flags in [("all processors", []), ("one thread", ["--threads", "1"])]:
        costs = []
        for _ in range(repeats):
            _, summary, row = map_row(loopstone, log, "speed", flags)
            row["stages"] = {key: summary[key] for key in STAGES}
            costs.append(row)
        say(f"  {name}: " + ", ".join(f"{row['wall_s']:.1f}" for row in costs) + " s wall")
        variant = {
            key: median([row[key] for row in costs]) for key in ("wall_s", "cpu_s", "peak_mb")
        }
        fastest = min(costs, key=lambda row: row["wall_s"])
        variant |= {
            "name": name,
            "scans": fastest["scans"],
            "flags": flags,
            "duration_s": fastest["duration_s"],
            "fastest_wall_s": fastest["wall_s"],
            "fastest_stages": fastest["stages"],
        }
        result["variants"].append(variant)
    return result


LAPS = [1, 10]
# Title, world, flags of simulate: drives of two kilometres and of twenty.
SPARSE = ["--format", "carmen", "--beams", 180, "--fov", 180, "--scan-rate", 5]
LONG_DRIVES = [
    ("campus", "campus", SPARSE),
    (
        "campus, far sight, usual effects",
        "campus",
        [*SPARSE, "--max-range", 80, "--realism", "usual"],
    ),
    (
        "corridors, far sight, usual effects, 7 laps",
        "loops",
        [*SPARSE, "--max-range", 80, "--realism", "usual", "--laps", 7],
    ),
    ("campus, 12 laps", "campus", [*SPARSE, "--laps", 12]),
]
PACES = [(1.0, 30.0), (10.0, 600.0)]  # times the log's own, and how much of the log [s]


def drive_row(loopstone, name, title, world, seed, flags):
    sim = loopstone.simulate(world, seed, flags)
    folder, summary, row = map_row(loopstone, sim / "log.clf", name, [])
    errors = ate_of(loopstone, folder / "trajectory.tum", sim)
    say(f"  {title}: {row['wall_s']:.1f} s, {row['peak_mb']:.0f} MB")
    return {
        **row,
        "drive": title,
        "path_m": summary["path_length_m"],
        "ate_m": errors["ate_rmse_m"],
        "thinned": summary["key_scans_thinned"],
        "keys": summary["key_scans"],
    }


def laps(loopstone):
    """The same way once and ten times: what the second to the tenth time cost; and long drives."""
    rows = []
    for count in LAPS:
        flags = ["--laps", count, "--format", "carmen"]
        title = f"office, laps: {count}"
        row = drive_row(loopstone, f"laps-{count}", title, "office", 1, flags)
        rows.append({**row, "laps": count})
    for i, (title, world, flags) in enumerate(LONG_DRIVES):
        rows.append(drive_row(loopstone, f"drive-{i}", title, world, 2, flags))
    return rows


def paced(loopstone, log, name, speed, duration_s, threads):
    """How long after a scan arrives its pose is known. One thread: everything on one processor
    (Loopstone.map)."""
    flags = ["--threads", threads, "--realtime", speed, "--duration", duration_s]
    _, summary, _ = loopstone.map(log, "online", flags)
    waits = {key: value for key, value in summary["realtime"].items() if key != "speed"}
    say(
        f"  {name}, {speed:.0f} x, {threads}: computing takes"
        f" {1e3 * waits['worst_computing_s']:.1f} ms at worst"
    )
    return {
        "log": name,
        "speed": speed,
        "threads": threads,
        "duration_s": summary["duration_s"],
        "scans": summary["scans"],
        "submaps": summary["submaps"],
        **waits,
    }


def online(loopstone, data, quick):
    """Logs replayed at their own pace and at ten times it, on one processor and on two."""
    logs = []
    if (data / "carmen" / "intel.clf").exists():
        logs.append(("Intel", data / "carmen" / "intel.clf", 600.0))
    campus = loopstone.simulate(
        "campus", 1, ["--format", "carmen", "--beams", 1081, "--fov", 270, "--scan-rate", 40]
    )
    logs.append(("campus, 1081 beams at 40 Hz", campus / "log.clf", 3600.0))
    rows = []
    for name, log, whole_s in logs:
        for speed, duration_s in PACES:
            length_s = 20.0 * speed if quick else (whole_s if speed > 1.0 else duration_s)
            rows += [paced(loopstone, log, name, speed, length_s, threads) for threads in (1, 2)]
    return rows


def live_map(loopstone, data):
    """How far the map that exists while a robot drives is from the finished one, refreshed every
    ten seconds."""
    program = loopstone.program.with_name("measure_live_map")
    if not program.exists():
        say(f"  {program}: not built, skipped (scripts/bench.sh builds it)")
        return None
    logs = [
        (title, data / "carmen" / f"{name}.clf")
        for name, title in [("intel", "Intel"), ("aces", "ACES"), ("mit-csail", "MIT CSAIL")]
    ]
    logs = [(title, log) for title, log in logs if log.exists()]
    logs += [
        (
            f"{world}, simulated",
            loopstone.simulate(world, 1, ["--format", "carmen", "--beams", 181, "--fov", 180])
            / "log.clf",
        )
        for world in ("office", "warehouse", "campus")
    ]
    return [{"log": title, **json.loads(run([program, log, "10"])[0])} for title, log in logs]


def peers(loopstone, data, repeats):
    """Recorded logs, in turn by Loopstone and by MRPT's icp-slam, one processor each."""
    if not mrpt_slam.is_here():
        say("  mrpt-apps and mrpt-common are not installed, skipped")
        return None
    rows = []
    for name, title in [
        ("intel", "Intel Research Lab"),
        ("aces", "ACES building"),
        ("mit-csail", "MIT CSAIL"),
    ]:
        log = data / "carmen" / f"{name}.clf"
        if not log.exists():
            continue
        icp_slam = mrpt_slam.IcpSlam(log, loopstone.work)
        ours, theirs = [], []
        for _ in range(repeats):
            ours.append(map_row(loopstone, log, "peers", ["--threads", "1"])[2])
            theirs.append(icp_slam.map())
        row = {"log": title, "repeats": repeats}
        for who, costs in [("ours", ours), ("theirs", theirs)]:
            row[who] = {
                key: median([cost[key] for cost in costs]) for key in ("wall_s", "cpu_s", "peak_mb")
            }
        say(f"  {title}: {row['ours']['cpu_s']:.1f} s CPU, icp-slam {row['theirs']['cpu_s']:.1f} s")
        rows.append(row)
    return rows


DEMO = [
    ["simulate", "office", "-o", "sim", "--seed", "1"],
    ["map", "sim", "-o", "out"],
    [
        "evaluate",
        "--estimate",
        "out/trajectory.tum",
        "--reference",
        "sim/truth.tum",
        "--map",
        "out/map.yaml",
        "--true-map",
        "sim/map.yaml",
    ],
]


def demo(loopstone):
    """What a user types and sees: (command, output) of a first session."""
    folder = loopstone.work / "demo"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    session = []
    for words in DEMO:
        output, _ = run([loopstone.program.resolve(), *words, "--quiet"], folder=folder)
        session.append(("loopstone " + " ".join(words), output))
    return session
