#!/usr/bin/env python3
"""Compares dead reckoning on the UCSD sets 20 and 21 with a published result, and says where the
difference comes from.

The reference (others_results/*/odometry_*_imu.npz) was computed by others from the same encoders
and gyro: X = (x, y, yaw) at the gyro's stamps. It is no truth. Each row of the table changes one
thing of ours, so a column that shrinks names the cause. The table goes into docs/accuracy.md
between the markers.

  bench/compare_ucsd_odometry.py [--program build/release/bin/loopstone]
                                [--data FOLDER] [--write docs/accuracy.md]
"""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError:
    raise SystemExit(
        "this script needs numpy: apt install python3-numpy, then run it with /usr/bin/python3"
    )

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from doc_blocks import write_block  # noqa: E402
from provenance import circumstances, provenance  # noqa: E402
from recorded import data_folder  # noqa: E402

BLOCK = "ucsd-odometry"

VARIANTS = [
    ("default: arcs, gyro heading, bias from standstill, interpolated", [], {}),
    ("no bias removal", ["--set", "use_standstill=false"], {}),
    (
        "no bias removal, nearest sample",
        ["--set", "use_standstill=false", "--align", "nearest"],
        {},
    ),
    ("no bias removal, Euler steps", ["--set", "use_standstill=false", "--euler"], {}),
    (
        "no bias removal, Euler steps, nearest sample",
        ["--set", "use_standstill=false", "--euler", "--align", "nearest"],
        {},
    ),
    ("heading from wheels, track 0.390 m", ["--yaw", "wheels"], {}),
    (
        "heading from wheels, track 0.311 m (inner edges)",
        ["--yaw", "wheels"],
        {"track_width_m": 0.31115},
    ),
    (
        "heading from wheels, track 0.476 m (outer edges)",
        ["--yaw", "wheels"],
        {"track_width_m": 0.47626},
    ),
    ("wheels 1 % larger", [], {"metres_per_count": 0.002222}),
]


def read_tum(path):
    rows = np.loadtxt(path)
    yaw = np.unwrap(2.0 * np.arctan2(rows[:, 6], rows[:, 7]))
    return rows[:, 0], np.column_stack([rows[:, 1:3], yaw])


def at_stamps(stamps, poses, wanted):
    return np.column_stack([np.interp(wanted, stamps, poses[:, k]) for k in range(3)])


def aligned_to_start(poses):
    """Seen from the first pose, so that both start at the origin."""
    c, s = np.cos(poses[0, 2]), np.sin(poses[0, 2])
    shifted = poses - poses[0]
    shifted[:, :2] = shifted[:, :2] @ np.array([[c, -s], [s, c]])
    return shifted


def run(program, log, flags, wheels, folder):
    output = folder / "odometry.tum"
    command = [program, "odometry", str(log), "-o", str(output), "--force", "--quiet", *flags]
    if wheels:
        robot = folder / "robot.toml"
        robot.write_text(
            "[wheels]\n" + "".join(f"{key} = {value}\n" for key, value in wheels.items())
        )
        command += ["--robot", str(robot)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return read_tum(output)


def textbook(sensors, number):
    """What the literature's exercise asks for, as a check on the explanation: gyro rate times its
    own time step, raw, the encoder speed held to the nearest gyro stamp, Euler steps."""
    encoders = np.load(sensors / f"Encoders{number}.npz")
    imu = np.load(sensors / f"Imu{number}.npz")
    te, counts = encoders["time_stamps"], encoders["counts"].astype(float)
    ti, rate = imu["time_stamps"], imu["angular_velocity"][2]
    speed = np.concatenate([[0.0], 0.0022 * counts.mean(axis=0)[1:] / np.diff(te)])
    after = np.clip(np.searchsorted(te, ti), 1, len(te) - 1)
    nearest = np.where(np.abs(te[after] - ti) < np.abs(te[after - 1] - ti), after, after - 1)
    dt = np.diff(ti)
    yaw = np.concatenate([[0.0], np.cumsum(rate[1:] * dt)])
    step = speed[nearest][1:] * dt
    x = np.concatenate([[0.0], np.cumsum(step * np.cos(yaw[:-1]))])
    y = np.concatenate([[0.0], np.cumsum(step * np.sin(yaw[:-1]))])
    return ti, np.column_stack([x, y, yaw])


def compare(stamps, poses, other_stamps, other):
    inside = (other_stamps >= stamps[0]) & (other_stamps <= stamps[-1])
    ours = aligned_to_start(at_stamps(stamps, poses, other_stamps[inside]))
    theirs = aligned_to_start(other[inside])
    apart = np.linalg.norm(ours[:, :2] - theirs[:, :2], axis=1)
    turn = np.degrees(ours[:, 2] - theirs[:, 2])
    return {
        "mean_m": apart.mean(),
        "end_m": apart[-1],
        "end_deg": turn[-1],
        "max_deg": np.abs(turn).max(),
        "path_ratio": (
            np.linalg.norm(np.diff(ours[:, :2], axis=0), axis=1).sum()
            / np.linalg.norm(np.diff(theirs[:, :2], axis=0), axis=1).sum()
        ),
    }


def table(program, data):
    sensors = data / "ucsd" / "sensors"
    others = sorted((data / "ucsd" / "others_results").glob("*/odometry_*_imu.npz"))
    version = (
        subprocess.run([program, "--version"], check=True, stdout=subprocess.PIPE)
        .stdout.decode()
        .strip()
    )
    lines = [provenance(circumstances(version)), ""]
    for result in others:
        number = int(re.search(r"odometry_(\d+)_imu", result.name).group(1))
        with np.load(result) as arrays:
            other_stamps = arrays["stamps"]
            other = arrays["X"].astype(float)
        other[:, 2] = np.unwrap(other[:, 2])
        lines += [
            (
                f"Set {number}:"
                f" {np.linalg.norm(np.diff(other[:, :2], axis=0), axis=1).sum():.1f} m,"
                f" {other_stamps[-1] - other_stamps[0]:.0f} s."
            ),
            "",
            (
                "| ours | mean distance [m] | distance at the end [m] | heading at the end [deg] "
                "| largest heading difference [deg] | path, ours / theirs |"
            ),
            "|---|---|---|---|---|---|",
        ]
        with tempfile.TemporaryDirectory() as folder:
            for name, flags, wheels in VARIANTS:
                row = compare(
                    *run(program, f"{sensors}#{number}", flags, wheels, pathlib.Path(folder)),
                    other_stamps,
                    other,
                )
                lines.append(
                    f"| {name} | {row['mean_m']:.3f} | {row['end_m']:.3f} | {row['end_deg']:+.2f} "
                    f"| {row['max_deg']:.2f} | {row['path_ratio']:.4f} |"
                )
        row = compare(*textbook(sensors, number), other_stamps, other)
        lines.append(
            "| (ten lines of numpy: raw gyro, nearest encoder speed, Euler) |"
            f" {row['mean_m']:.3f} | {row['end_m']:.3f} | {row['end_deg']:+.2f} |"
            f" {row['max_deg']:.2f} | {row['path_ratio']:.4f} |"
        )
        lines.append("")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/loopstone"))
    parser.add_argument("--data", type=pathlib.Path, default=data_folder(ROOT))
    parser.add_argument(
        "--write", type=pathlib.Path, help="put the table into this file instead of printing it"
    )
    arguments = parser.parse_args()
    text = table(arguments.program, arguments.data)
    if arguments.write:
        write_block(arguments.write, BLOCK, text)
    else:
        print(text)


if __name__ == "__main__":
    main()
