#!/usr/bin/env python3
"""Calibrates simulated robots whose laser does not sit where the robot file says, compares with the
truth in world.json, maps the same logs with and without the correction, and writes the table of
docs/calibration.md.

  bench/calibration.py              office and warehouse, five seeds each (about ten minutes)
  bench/calibration.py --quick      two seeds, 150 s of each drive; prints the table
"""
import concurrent.futures
import json
import math
import pathlib
import shutil
import statistics
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from doc_blocks import table, write_block  # noqa: E402
from program import Loopstone, run, say  # noqa: E402
from sections import plain_parser  # noqa: E402
from provenance import circumstances, provenance  # noqa: E402

PAGE, BLOCK = ROOT / "docs/calibration.md", "calibration"
WORLDS = ["office", "warehouse"]
EFFECTS = ["mount", "mount,wheels,gyro", "sweep", "upside_down", "usual", "none"]
SEEDS = 5
BEAMS = 361
SCANS = ["--beams", BEAMS, "--scan-rate", "5"]
QUICK_S = 150


def true_mount(folder):
    """What was drawn, else what the robot file says."""
    world = json.loads((folder / "world.json").read_text())
    drawn = (world.get("realism") or {}).get("drawn", {}).get("mount")
    if drawn:
        return {name: drawn[f"robot_T_lidar_{name}"] for name in ("x_m", "y_m", "yaw_rad")}
    return world["robot"]["robot_T_lidar"]


def true_sweep(folder):
    """From the first beam to where one more would follow; None where the log tells it."""
    world = json.loads((folder / "world.json").read_text())
    drawn = (world.get("realism") or {}).get("drawn", {}).get("sweep")
    return drawn["sweep_s"] * BEAMS / (BEAMS - 1) if drawn else None


def heading_and_way(loopstone, folder, name, flags):
    """Errors of the map's path: heading [deg], position [m]."""
    out, _, _ = loopstone.map(folder, name, flags)
    error = loopstone.evaluate(
        "--estimate", out / "trajectory.tum", "--reference", folder / "truth.tum", "--align", "se2"
    )
    shutil.rmtree(out)
    return error["ate_rotation_deg"]["rmse"], error["ate_rmse_m"]


def measure(loopstone, world, effect, seed, flags):
    folder = loopstone.work / f"sim-calibration-{world}-{effect.replace(',', '+')}-{seed}"
    words = [loopstone.program, "simulate", world, "-o", folder, "--seed", seed, *SCANS, *flags]
    if effect != "none":
        words += ["--realism", effect]
    run([*words, "--force", "--quiet"])
    found = json.loads(run([loopstone.program, "calibrate", folder, "--json", "--quiet"])[0])
    truth = true_mount(folder)
    row = {"off": found["lidar"]["is_off"], "errors": {}, "sigmas": {}}
    for name in ("x_m", "y_m", "yaw_rad"):
        value = found["lidar"][name]
        error = value["value"] - truth[name]
        row["errors"][name] = math.remainder(error, math.tau) if name == "yaw_rad" else error
        row["sigmas"][name] = value["sigma"]
    sweep, truly = found["lidar"]["sweep_s"], true_sweep(folder)
    if truly is not None:
        row["errors"]["sweep_s"] = sweep["value"] - truly
        row["sigmas"]["sweep_s"] = sweep["sigma"]
    name = f"calibration-{world}-{effect.replace(',', '+')}-{seed}"
    row["told"] = heading_and_way(loopstone, folder, name, ["--no-calibration"])
    row["corrected"] = heading_and_way(loopstone, folder, name, [])
    shutil.rmtree(folder)
    e, s = row["errors"], row["sigmas"]
    say(
        f"  {world} {effect} {seed}: x {1e3 * e['x_m']:.1f} +- {1e3 * s['x_m']:.1f} mm,"
        f" y {1e3 * e['y_m']:.1f} +- {1e3 * s['y_m']:.1f} mm,"
        f" yaw {math.degrees(e['yaw_rad']):.3f} +- {math.degrees(s['yaw_rad']):.3f} deg;"
        f" heading {row['told'][0]:.2f} -> {row['corrected'][0]:.2f} deg"
    )
    return row


def rms(values):
    return math.sqrt(statistics.fmean(value * value for value in values))


def cells_of(world, effect, rows):
    def error(name, unit, digits):
        return f"{rms([unit * row['errors'][name] for row in rows]):.{digits}f}"

    def sigma(name, unit, digits):
        return f"{rms([unit * row['sigmas'][name] for row in rows]):.{digits}f}"

    def path(which, part, digits):
        return f"{statistics.fmean(row[which][part] for row in rows):.{digits}f}"

    yaw = math.degrees(1.0)
    has_sweep = all("sweep_s" in row["errors"] for row in rows)
    return [
        world,
        effect,
        str(len(rows)),
        f"{error('x_m', 1e3, 1)} ({sigma('x_m', 1e3, 1)})",
        f"{error('y_m', 1e3, 1)} ({sigma('y_m', 1e3, 1)})",
        f"{error('yaw_rad', yaw, 3)} ({sigma('yaw_rad', yaw, 3)})",
        f"{error('sweep_s', 1e3, 1)} ({sigma('sweep_s', 1e3, 1)})" if has_sweep else "",
        str(sum(row["off"] for row in rows)),
        path("told", 0, 2),
        path("corrected", 0, 2),
        path("told", 1, 3),
        path("corrected", 1, 3),
    ]


def text_of(when, rows):
    header = ["world", "effects", "logs>", "x [mm]>", "y [mm]>", "yaw [deg]>", "sweep [ms]>"]
    header += ["mount said to be off>"]
    header += ["heading as told [deg]>", "corrected [deg]>", "path as told [m]>", "corrected [m]>"]
    return "\n".join(
        [
            provenance(when),
            "",
            "Errors beside the truth, rms, and in brackets what calibration says they are. Errors"
            " of the path are rms, mean of the logs.",
            "",
            table(header, rows),
        ]
    )


def main():
    arguments = plain_parser(__doc__, ROOT).parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    when = circumstances(loopstone.version())
    flags = ["--duration", QUICK_S] if arguments.quick else []
    rows = []
    for world in WORLDS:
        for effect in EFFECTS:
            logs = range(1, 1 + (2 if arguments.quick else SEEDS))
            with concurrent.futures.ThreadPoolExecutor(2) as pool:
                measured = list(
                    pool.map(lambda seed: measure(loopstone, world, effect, seed, flags), logs)
                )
            rows.append(cells_of(world, effect, measured))
    text = text_of(when, rows)
    if arguments.quick:
        print(text)
    else:
        write_block(PAGE, BLOCK, text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
