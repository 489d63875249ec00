#!/usr/bin/env python3
"""Measures how fast recordings are read, beside rosbags and mcap, and writes the tables of
docs/benchmarks.md.

The recordings are made here, of a simulated drive with the pictures of a camera beside it, one
after the other in build/bench/recordings. The libraries that write them, and that are measured in
the same run, are those of build/oracles (scripts/install_oracles.sh), else the system's. What was
measured is kept in build/bench/recordings.json.

  bench/recordings.py            measures and writes (some minutes; 1.5 GB of disk)
  bench/recordings.py --large    instead: maps an MCAP of 10 GB (20 GB of disk while it is made)
  bench/recordings.py --quick    small recordings, read once; to look at, writes nothing into docs/
  bench/recordings.py --again    no measurement: writes the tables from recordings.json again
"""
import argparse
import json
import math
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import tables  # noqa: E402
from doc_blocks import table, write_block  # noqa: E402
from program import MEGABYTE, Loopstone, median, run, say  # noqa: E402
from provenance import circumstances, provenance  # noqa: E402
from sections import verdicts  # noqa: E402

PAGE = ROOT / "docs/benchmarks.md"
BLOCKS = {"speed": "recordings", "large": "recordings-large"}
PEERS = ROOT / "bench/peers"
REPEATS = 3
TARGET_MB_PER_S = 300.0
LARGE_PEAK_MB = 500.0
BYTES_PER_S = 14.4e6  # of messages, most of them pictures
SHORTEST_LAP_S = 500.0  # of the office
# Container, what it is called, what of the messages' size is recorded of it: bzip2 is slow.
CONTAINERS = [
    ("bag", "bag", 1.0),
    ("bag-lz4", "bag, lz4", 1.0),
    ("bag-bz2", "bag, bz2", 0.1),
    ("mcap", "MCAP", 1.0),
    ("mcap-lz4", "MCAP, lz4", 1.0),
    ("mcap-zstd", "MCAP, zstd", 1.0),
    ("rosbag2", "rosbag2, SQLite", 1.0),
]
WAYS = {"scans": "scans alone, decoded", "all": "every message", "log": "as a log"}
PEER_WAYS = ["scans", "raw", "all"]
# Which of ours does no less than the peer.
COMPARED = {"scans": "scans", "raw": "scans", "all": "all"}


def python_of_peers():
    """An interpreter that has the libraries, and their versions."""
    for python in (ROOT / "build/oracles/venv/bin/python", pathlib.Path(sys.executable)):
        if not python.exists():
            continue
        if (
            subprocess.run(
                [python, "-c", "import numpy, mcap, mcap_ros2, rosbags"],
                stderr=subprocess.DEVNULL,
                check=False,
            ).returncode
            == 0
        ):
            return python, json.loads(run([python, PEERS / "recording_reader.py", "--versions"])[0])
    raise SystemExit(
        "rosbags, mcap, mcap-ros2-support and numpy are needed to make recordings:"
        " scripts/install_oracles.sh"
    )


def peers_of(container):
    return ["rosbags", "mcap"] if container.startswith("mcap") else ["rosbags"]


def make_drive(loopstone, seconds):
    """A folder with log.mcap, odometry.tum and truth.tum."""
    laps = math.ceil(seconds / SHORTEST_LAP_S)
    words = ["--format", "mcap", "--scan-rate", 40, "--set", "imu.rate_hz=200"]
    folder = loopstone.simulate("office", 1, [*words, "--laps", laps, "--duration", seconds])
    loopstone.odometry(folder / "log.mcap").rename(folder / "odometry.tum")
    return folder


def seconds_of(megabytes):
    return math.ceil(megabytes * MEGABYTE / BYTES_PER_S) + 1


def drop(path):
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def write_recording(python, container, drive, path, seconds, most_bytes=0):
    """What the writer says of it: messages by topic, and their bytes."""
    drop(path)
    writer = PEERS / "recording_writer.py"
    return json.loads(run([python, writer, container, drive, path, seconds, most_bytes])[0])


def one_run(command):
    """What the program says of itself, and the peak memory as the kernel has it."""
    output, cost = run(command)
    return {**json.loads(output), "peak_mb": cost["peak_mb"]}


def medians(runs):
    return {
        "messages": runs[0]["messages"],
        **{key: median([one[key] for one in runs]) for key in ("cpu_s", "wall_s", "peak_mb")},
    }


def check_counts(name, rows, written):
    """Nobody is fast by leaving something out."""
    expected = {"all": sum(written["messages"].values())}
    expected["scans"] = expected["raw"] = written["messages"]["/scan"]
    for (system, way), row in rows.items():
        if way in expected and row["messages"] != expected[way]:
            raise SystemExit(
                f"{name}: {system} found {row['messages']} messages ({way}), not {expected[way]}"
            )


def read_recording(programs, python, container, path, repeats):
    """{(system, way): [what one run took]}, all of them in turn."""
    commands = {("loopstone", way): [programs / "measure_recordings", path, way] for way in WAYS}
    for peer in peers_of(container):
        for way in PEER_WAYS:
            commands[peer, way] = [python, PEERS / "recording_reader.py", peer, way, path]
    runs = {key: [] for key in commands}
    for _ in range(repeats):
        for key, command in commands.items():
            runs[key].append(one_run(command))
    damage = [one["damage"] for one in runs["loopstone", "all"] if one["damage"]]
    if damage:
        raise SystemExit(f"{path}: Loopstone takes it for damaged in {damage[0]} places")
    return runs


def measure_speed(loopstone, programs, python, arguments):
    rows = []
    drive = make_drive(loopstone, seconds_of(arguments.megabytes))
    for container, title, share in CONTAINERS:
        path = loopstone.work / f"{container}.{container.split('-')[0]}"
        seconds = arguments.megabytes * share * MEGABYTE / BYTES_PER_S
        written = write_recording(python, container, drive, path, seconds)
        runs = read_recording(programs, python, container, path, arguments.repeats)
        found = {key: medians(of) for key, of in runs.items()}
        check_counts(title, found, written)
        row = {
            "container": container,
            "title": title,
            "file_mb": runs["loopstone", "all"][0]["file_bytes"] / MEGABYTE,
            "message_mb": written["message_bytes"] / MEGABYTE,
            "runs": {"/".join(key): of for key, of in found.items()},
        }
        rows.append(row)
        if not arguments.keep:
            drop(path)
        rates = (f"{way} {rate(row, 'loopstone', way):.0f} MB/s" for way in WAYS)
        say(f"  {title}, {row['file_mb']:.0f} MB: {', '.join(rates)}")
    return {"repeats": arguments.repeats, "rows": rows}


def need_disk(folder, megabytes):
    """For the file and the drive that it is made of, with as much again to spare."""
    free_mb = shutil.disk_usage(folder).free / MEGABYTE
    if free_mb < 2.0 * megabytes:
        raise SystemExit(f"{folder}: {free_mb:.0f} MB are free, {2.0 * megabytes:.0f} are needed")


def measure_large(loopstone, python, arguments):
    container = "mcap-zstd"
    most_bytes = round(arguments.megabytes * MEGABYTE)
    need_disk(loopstone.work, arguments.megabytes)
    seconds = 2.5 * seconds_of(arguments.megabytes)  # zstd leaves about half of it
    drive = make_drive(loopstone, seconds)
    path = loopstone.work / "large.mcap"
    written = write_recording(python, container, drive, path, seconds, most_bytes)
    file_mb = path.stat().st_size / MEGABYTE
    if file_mb < 0.99 * arguments.megabytes:
        raise SystemExit(f"{path}: only {file_mb:.0f} MB, the drive was too short")
    say(f"  {file_mb:.0f} MB are written")
    folder, summary, cost = loopstone.map(path, "large")
    errors = loopstone.evaluate(
        "--estimate", folder / "trajectory.tum", "--reference", drive / "truth.tum"
    )
    return {
        "file_mb": file_mb,
        "message_mb": written["message_bytes"] / MEGABYTE,
        "messages": sum(written["messages"].values()),
        "scans": summary["scans"],
        "duration_s": summary["duration_s"],
        "wall_s": summary["wall_time_s"],
        "cpu_s": cost["cpu_s"],
        "peak_mb": max(summary["peak_memory_bytes"] / MEGABYTE, cost["peak_mb"]),
        "ate_m": errors["ate_rmse_m"],
    }


def rate(row, system, way):
    """[MB/s] of the file, by CPU time."""
    return row["file_mb"] / row["runs"][f"{system}/{way}"]["cpu_s"]


def own_table(rows):
    cells = [
        [
            row["title"],
            f"{row['file_mb']:.0f}",
            f"{row['message_mb']:.0f}",
            *[f"{rate(row, 'loopstone', way):,.0f}" for way in WAYS],
            *[f"{row['runs'][f'loopstone/{way}']['peak_mb']:.0f}" for way in ("scans", "log")],
        ]
        for row in rows
    ]
    header = ["", "file [MB]>", "messages [MB]>", *[f"{way} [MB/s]>" for way in WAYS.values()]]
    return table([*header, "peak memory: scans alone [MB]>", "as a log [MB]>"], cells)


def peer_table(rows):
    cells = []
    for row in rows:
        for peer in peers_of(row["container"]):
            line = [row["title"], peer]
            for way in PEER_WAYS:
                theirs = rate(row, peer, way)
                times = rate(row, "loopstone", COMPARED[way]) / theirs
                line += [f"{theirs:,.0f}", f"{times:.1f}"]
            peaks = [row["runs"][f"{peer}/{way}"]["peak_mb"] for way in PEER_WAYS]
            cells.append([*line, f"{max(peaks):.0f}"])
    header = ["", "library", "scans alone, decoded [MB/s]>", "Loopstone / library>"]
    header += ["scans alone, not decoded [MB/s]>", "Loopstone, decoding / library>"]
    header += ["every message [MB/s]>", "Loopstone / library>", "peak memory [MB]>"]
    return table(header, cells)


def speed_targets(figures):
    return [
        (
            f"{row['title']}: read on one core, scans alone",
            f">= {TARGET_MB_PER_S:.0f} MB/s",
            f"{rate(row, 'loopstone', 'scans'):,.0f} MB/s",
            rate(row, "loopstone", "scans") >= TARGET_MB_PER_S,
        )
        for row in figures["rows"]
        if row["container"].startswith(("bag", "mcap"))
    ]


def large_targets(figures):
    return [
        (
            f"MCAP of {1e-3 * figures['file_mb']:.1f} GB: peak memory of mapping",
            f"< {LARGE_PEAK_MB:.0f} MB",
            f"{figures['peak_mb']:.0f} MB",
            figures["peak_mb"] < LARGE_PEAK_MB,
        )
    ]


def speed_text(section):
    figures = section["figures"]
    return "\n".join(
        [
            f"{provenance(section)} Peers in the same run: {', '.join(section['peers'])}.",
            "",
            (
                f"MB of the file per second of CPU time, one thread, the median of"
                f" {figures['repeats']} {'run' if figures['repeats'] == 1 else 'runs in turn'}."
            ),
            "",
            own_table(figures["rows"]),
            "",
            peer_table(figures["rows"]),
            "",
            tables.targets_table(speed_targets(figures)),
        ]
    )


def large_text(section):
    figures = section["figures"]
    cells = [
        f"{1e-3 * figures['file_mb']:.1f}",
        f"{1e-3 * figures['message_mb']:.1f}",
        f"{figures['messages']}",
        f"{figures['scans']}",
        f"{figures['duration_s']:.0f}",
        f"{figures['wall_s']:.1f}",
        f"{figures['cpu_s']:.1f}",
        f"{figures['peak_mb']:.0f}",
        f"{1e3 * figures['ate_m']:.1f}",
    ]
    header = ["file [GB]>", "messages [GB]>", "messages>", "scans>", "drive [s]>", "wall [s]>"]
    header += ["CPU [s]>", "peak memory [MB]>", "ATE rmse [mm]>"]
    parts = [provenance(section), "", table(header, [cells]), ""]
    return "\n".join([*parts, tables.targets_table(large_targets(figures))])


TEXTS = {"speed": speed_text, "large": large_text}
TARGETS = {"speed": speed_targets, "large": large_targets}


def parse():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/release/bin")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/bench")
    parser.add_argument("--megabytes", type=float, help="of messages; with --large of the file")
    parser.add_argument("--repeats", type=int, default=REPEATS)
    parser.add_argument("--large", action="store_true")
    parser.add_argument("--keep", action="store_true", help="the recordings")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--again", action="store_true")
    arguments = parser.parse_args()
    if arguments.megabytes is None:
        full, small = (10000.0, 100.0) if arguments.large else (500.0, 30.0)
        arguments.megabytes = small if arguments.quick else full
    if arguments.quick:
        arguments.repeats = 1
    return arguments


def measure(arguments):
    """The section that was asked for."""
    python, versions = python_of_peers()
    work = arguments.work / "recordings"
    work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", work)
    when = {**circumstances(loopstone.version()), "peers": versions}
    try:
        if arguments.large:
            figures = measure_large(loopstone, python, arguments)
        else:
            figures = measure_speed(loopstone, arguments.programs, python, arguments)
    finally:
        if not arguments.keep:
            shutil.rmtree(work)
    return {**when, "figures": figures}


def main():
    arguments = parse()
    kept = arguments.work / f"recordings{'-quick' if arguments.quick else ''}.json"
    sections = json.loads(kept.read_text()) if kept.exists() else {}
    if not arguments.again:
        sections["large" if arguments.large else "speed"] = measure(arguments)
        kept.write_text(json.dumps(sections, indent=1))
    for name, section in sections.items():
        if arguments.quick:
            print(f"\n{BLOCKS[name]}\n{TEXTS[name](section)}\n")
        else:
            write_block(PAGE, BLOCKS[name], TEXTS[name](section))
        print(verdicts(TARGETS[name](section["figures"])))


if __name__ == "__main__":
    main()
