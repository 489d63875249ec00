#!/usr/bin/env python3
"""Holds the readers and writers of recordings against the reference libraries, both ways: rosbags,
mcap and mcap_ros2 of Python, @foxglove/rosbag of Node.

  scripts/install_oracles.sh && tests/oracles/check_recordings.py [--program PROGRAM] [--only WORD]

What they write of a short drive must come out of Loopstone unchanged, what Loopstone writes must be
the same to all of them, and of what is cut or damaged it must find no less than they do. Recorded
bags in $LOOPSTONE_DATA/bags (../shared/data/bags) are counted, too, where they are.
"""
import argparse
import csv
import json
import os
import pathlib
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PYTHON = ROOT / "build/oracles/venv/bin/python"
if PYTHON.exists() and pathlib.Path(sys.prefix) != PYTHON.parent.parent:
    os.execv(PYTHON, [str(PYTHON), *sys.argv])

try:
    import numpy as np
    import readers
    import writers
    from drive import Scan, Told, by_convention, counts_of, drive, expected
    from rosbags.interfaces import QosDurability
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader as Reader2
    from rosbags.typesys import get_types_from_msg
except ImportError as error:
    sys.exit(f"{error}: run scripts/install_oracles.sh first")


def require(condition, text):
    if not condition:
        raise AssertionError(text)


class Checks:
    """Runs checks by name and counts them."""

    def __init__(self, program, folder, only):
        self.program = program
        self.folder = folder
        self.only = only
        self.passed = 0
        self.failed = 0
        self.number = 0

    def __call__(self, name, check, *arguments):
        if self.only not in name:
            return
        self.number += 1
        folder = self.folder / f"{self.number:03}"
        folder.mkdir()
        try:
            check(self, folder, *arguments)
            self.passed += 1
        except Exception as error:  # of any library: each is a finding
            self.failed += 1
            kind = "" if isinstance(error, AssertionError) else f"{type(error).__name__}: "
            print(f"FAILED {name}\n    {kind}{error}\n    its files: {folder}", flush=True)
            return
        shutil.rmtree(folder)

    def run(self, *arguments):
        """The JSON that the program prints."""
        command = [self.program, *map(str, arguments), "--json"]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        said = done.stderr.decode(errors="replace").strip()
        require(done.returncode == 0, f"`{' '.join(command)}` ended with {done.returncode}: {said}")
        return json.loads(done.stdout)


# Comparisons.

# Of angles that were turned into quaternions and back, and of products with rotations.
ROUNDING = 1e-12


def same_scan(name, found, wanted):
    require(found[:-1] == wanted[:-1], f"{name}: {found[:-1]} instead of {wanted[:-1]}")
    require(
        np.array_equal(found.ranges, wanted.ranges, equal_nan=True),
        f"{name} at {wanted.stamp_ns}: ranges {found.ranges[:20]} instead of {wanted.ranges[:20]}",
    )


def same_numbers(name, found, wanted, tolerance=ROUNDING):
    found, wanted = np.array(found, dtype=float), np.array(wanted, dtype=float)
    require(found.shape == wanted.shape, f"{name}: {found.shape} instead of {wanted.shape}")
    if found.size:
        worst = float(np.max(np.abs(found - wanted)))
        require(worst <= tolerance, f"{name}: up to {worst} off")


def same_stamps(name, found, wanted):
    require(len(found) == len(wanted), f"{name}: {len(found)} instead of {len(wanted)}")
    for a, b in zip(found, wanted):
        require(a == b, f"{name}: stamp {a} instead of {b}")


def compare(found, wanted):
    require(
        sorted(found.scans) == sorted(wanted.scans),
        f"scans of {sorted(found.scans)} instead of {sorted(wanted.scans)}",
    )
    for topic, scans in wanted.scans.items():
        same_stamps(topic, [s.stamp_ns for s in found.scans[topic]], [s.stamp_ns for s in scans])
        for a, b in zip(found.scans[topic], scans):
            same_scan(topic, a, b)
    for name, a, b in (
        ("odometry", found.poses, wanted.poses),
        ("imu", found.imu, wanted.imu),
        ("wheels", found.ticks, wanted.ticks),
    ):
        same_stamps(name, [row[0] for row in a], [row[0] for row in b])
        same_numbers(name, [np.hstack(row[1:]) for row in a], [np.hstack(row[1:]) for row in b])
    require(
        sorted(found.mounts) == sorted(wanted.mounts),
        f"mounts of {sorted(found.mounts)} instead of {sorted(wanted.mounts)}",
    )
    for frame, mount in wanted.mounts.items():
        same_numbers(f"mount of {frame}", found.mounts[frame], mount)


def same_counts(found, wanted):
    for topic in sorted(set(found) | set(wanted)):
        a, b = found.get(topic, 0), wanted.get(topic, 0)
        require(a == b, f"{topic}: {a} messages instead of {b}")


def counts_in(checks, path):
    summary = checks.run("info", path)
    return {topic["name"]: topic["messages"] for topic in summary["topics"]}


# They write, we read.


def comes_through(checks, folder, name, write, messages, wanted):
    path = folder / name
    write(path, messages)
    if name.endswith(".db3"):  # the file alone, without its folder
        path = writers.database_of(path)
    same_counts(counts_in(checks, path), counts_of(messages))
    checks.run("convert", path, folder / "out.mcap", "--strict")
    compare(readers.by_mcap(folder / "out.mcap"), wanted)


def padded(path, messages):
    plain = path.with_suffix(".plain")
    writers.write_mcap(plain, messages, use_chunking=False, **writers.NO_SUMMARY)
    writers.pad_records(plain, path)
    require(readers.count_mcap(path) == len(messages), "the padded file is not well made")


def ros1_in_mcap(path, messages):
    writers.write_mcap(path, messages, encoding="ros1")
    readers.by_mcap(path)


def check_what_they_write(checks):
    messages = drive()
    wanted = expected(messages)

    def check(name, file, write):
        checks(f"read: {name}", comes_through, file, write, messages, wanted)

    for packing in (None, "bz2", "lz4"):
        check(
            f"bag of rosbags, {packing or 'plain'}",
            "drive.bag",
            lambda path, all, packing=packing: writers.write_bag(path, all, packing),
        )
    for storage in ("sqlite3", "mcap"):
        for version in (8, 9):
            for packing in ("none", "file", "message", "storage"):
                if packing == "storage" and storage == "sqlite3":
                    continue
                check(
                    f"rosbag2 of rosbags, {storage}, version {version}, packing {packing}",
                    "drive",
                    lambda path, all, options=(storage, packing, version): writers.write_rosbag2(
                        path, all, *options
                    ),
                )
    check(
        "rosbag2 of rosbags, big-endian",
        "drive",
        lambda path, all: writers.write_rosbag2(path, all, encoding="cdr_big"),
    )
    check("database of rosbag2 alone", "drive.db3", writers.write_rosbag2)
    check("rosbag2 without definitions and metadata.yaml", "drive", writers.write_old_rosbag2)
    check("rosbag2 that was left open", "drive", writers.write_open_rosbag2)

    for packing, packing_options in writers.MCAP_PACKINGS.items():
        for name, options in writers.MCAP_OPTIONS.items():
            check(
                f"mcap, {packing}, {name}",
                "drive.mcap",
                lambda path, all, options={**packing_options, **options}: writers.write_mcap(
                    path, all, **options
                ),
            )
        if packing != "no chunks":  # which mcap_ros2 does not offer
            check(
                f"mcap of mcap_ros2, {packing}",
                "drive.mcap",
                lambda path, all, options=packing_options: writers.write_mcap_ros2(
                    path, all, **options
                ),
            )
    check("mcap, ROS 1", "drive.mcap", ros1_in_mcap)
    check(
        "mcap, ROS 1, no chunks, without summary",
        "drive.mcap",
        lambda path, all: writers.write_mcap(
            path, all, encoding="ros1", use_chunking=False, **writers.NO_SUMMARY
        ),
    )
    check(
        "mcap, big-endian",
        "drive.mcap",
        lambda path, all: writers.write_mcap(path, all, encoding="cdr_big"),
    )
    check(
        "mcap, two publishers a topic",
        "drive.mcap",
        lambda path, all: writers.write_mcap(path, all, publishers=2),
    )
    check("mcap, padded records and unknown ones", "drive.mcap", padded)


# We write, they read.

WRITTEN = {"mcap": "written.mcap", "bag": "written.bag", "rosbag2": "written"}
CUSTOM = "loopstone_msgs/msg/WheelTicks"


def read_by_all(path, kind):
    """(who, what it found)"""
    if kind == "mcap":
        yield "mcap, seeking", readers.by_mcap(path)
        yield "mcap, streaming", readers.by_mcap(path, is_seeking=False)
        return
    yield "rosbags", readers.by_rosbags(path)
    if kind == "bag":
        yield "@foxglove/rosbag", readers.by_foxglove(path)


def is_read_by_all(path, kind, wanted):
    for who, found in read_by_all(path, kind):
        try:
            compare(found, wanted)
        except AssertionError as error:
            raise AssertionError(f"{who}: {error}") from error


def converted(checks, folder, kind, messages, wanted):
    writers.write_rosbag2(folder / "drive", messages)
    path = folder / WRITTEN[kind]
    checks.run("convert", folder / "drive", path, "--format", kind)
    is_read_by_all(path, kind, wanted)


STANDARD_GRAVITY = 9.80665


def npz(folder, name):
    return np.load(folder / f"{name}20.npz")


def told_by_ucsd(folder):
    """The simulated log as NumPy reads it from arrays: there stamps are doubles."""
    lidar, wheels, imu = npz(folder, "Hokuyo"), npz(folder, "Encoders"), npz(folder, "Imu")

    def ns(stamps):
        return [round(stamp * 1e9) for stamp in stamps]

    ranges = lidar["ranges"].T.astype(np.float32)
    ranges[ranges == 0] = np.nan
    numbers = [
        float(np.float32(lidar[key]))
        for key in ("angle_min", "angle_increment", "time_increment", "range_min", "range_max")
    ]
    scans = [Scan(stamp, *numbers, row) for stamp, row in zip(ns(lidar["time_stamps"]), ranges)]
    accelerations = STANDARD_GRAVITY * imu["linear_acceleration"].T
    with open(ROOT / "robots/ucsd.toml", "rb") as robot:
        mount = tomllib.load(robot)["lidars"][0]
    return Told(
        scans={"/scan": scans},
        poses=[],
        imu=list(zip(ns(imu["time_stamps"]), imu["angular_velocity"].T, accelerations)),
        mounts={"laser": tuple(mount[name] for name in ("x_m", "y_m", "height_m", "yaw_rad"))},
        ticks=list(zip(ns(wheels["time_stamps"]), wheels["counts"].T.astype(float))),
    )


def near_stamps(found, wanted):
    """`found` with the stamps of `wanted` where these differ by the digits of doubles alone."""

    def near(a, b):
        return b if abs(a - b) <= 500 else a

    scans = {
        topic: [
            one._replace(stamp_ns=near(one.stamp_ns, other.stamp_ns))
            for one, other in zip(rows, wanted.scans[topic])
        ]
        for topic, rows in found.scans.items()
    }

    def rows(a, b):
        return [(near(one[0], other[0]), *one[1:]) for one, other in zip(a, b)]

    return found._replace(
        scans=scans, imu=rows(found.imu, wanted.imu), ticks=rows(found.ticks, wanted.ticks)
    )


def simulated(checks, folder, kind):
    options = ("office", "--seed", "3", "--duration", "5")
    checks.run("simulate", *options, "-o", folder / "ucsd")
    checks.run("simulate", *options, "-o", folder / "sim", "--format", kind)
    path = folder / "sim" if kind == "rosbag2" else next((folder / "sim").glob(f"*.{kind}"))
    wanted = told_by_ucsd(folder / "ucsd")
    require(len(wanted.scans["/scan"]) > 40, "the simulated log is too short")
    for _, found in read_by_all(path, kind):
        same_counts(
            {"scans": len(found.scans["/scan"]), "imu": len(found.imu), "ticks": len(found.ticks)},
            {
                "scans": len(wanted.scans["/scan"]),
                "imu": len(wanted.imu),
                "ticks": len(wanted.ticks),
            },
        )
        compare(near_stamps(found, wanted), wanted)
    same_counts(counts_in(checks, path), told_counts(wanted))


def told_counts(told):
    counts = {topic: len(scans) for topic, scans in told.scans.items()}
    return counts | {"/imu/data": len(told.imu), "/wheel_ticks": len(told.ticks), "/tf_static": 1}


def write_all_types(checks, folder, kind):
    """A recording with every type that is written: lasers, odometry, IMU, tf; or wheels."""
    drive_path = folder / "drive"
    writers.write_rosbag2(drive_path, drive(scans=20))
    checks.run("simulate", "rooms", "-o", folder / "sim", "--duration", "5", "--beams", "61")
    for source, name in ((drive_path, "a"), (folder / "sim", "b")):
        path = folder / f"{name}_{WRITTEN[kind]}"
        checks.run("convert", source, path, "--format", kind)
        yield path


def has_right_md5(checks, folder):
    for path in write_all_types(checks, folder, "bag"):
        with Reader1(path) as reader:
            require(len(reader.connections) >= 3, "too few topics")
            for connection in reader.connections:
                store = writers.ros1_store()
                types = get_types_from_msg(connection.msgdef.data, connection.msgtype)
                known = connection.msgtype in store.fielddefs
                require(known or connection.msgtype == CUSTOM, f"unknown {connection.msgtype}")
                if known:
                    right = store.generate_msgdef(connection.msgtype)[1]
                    require(
                        connection.digest == right, f"{connection.topic}: md5 {connection.digest}"
                    )
                told_by_text = writers.get_typestore(writers.Stores.EMPTY)
                told_by_text.register(types)
                right = told_by_text.generate_msgdef(connection.msgtype)[1]
                require(
                    connection.digest == right,
                    f"{connection.topic}: md5 {connection.digest}, by its definition {right}",
                )


def right_hash(name, definition):
    """By the library's own definition, and by the one in the file."""
    stores = [writers.get_typestore(writers.Stores.EMPTY)]
    stores[0].register(get_types_from_msg(definition, name))
    if name != CUSTOM:
        stores.append(writers.ros2_store())
    return {store.hash_rihs01(name) for store in stores}


def has_right_hashes(checks, folder):
    for path in write_all_types(checks, folder, "rosbag2"):
        with Reader2(path) as reader:
            require(len(reader.connections) >= 3, "too few topics")
            for connection in reader.connections:
                right = right_hash(connection.msgtype, connection.msgdef.data)
                require({connection.digest} == right, f"{connection.topic}: {connection.digest}")
                durability = connection.ext.offered_qos_profiles[0].durability
                is_latched = durability == QosDurability.TRANSIENT_LOCAL
                require(
                    is_latched == (connection.topic == "/tf_static"),
                    f"{connection.topic}: durability {durability}",
                )
            listed = {c.topic: c.msgcount for c in reader.connections}
            counted = {c.topic: 0 for c in reader.connections}
            for connection, _, _ in reader.messages():
                counted[connection.topic] += 1
            same_counts(listed, counted)
            require(reader.message_count == sum(counted.values()), "message_count is wrong")


def is_right_mcap(path):
    """Its summary, its definitions and their hashes. Gives what it holds: types, by topic."""
    types, counted = {}, {}
    with open(path, "rb") as stream:
        reader = readers.SeekingReader(
            stream, validate_crcs=True, decoder_factories=[readers.Ros2Decoder()]
        )
        summary = reader.get_summary()
        require(reader.get_header().profile == "ros2", "its profile is not ros2")
        for schema, channel, _, _ in reader.iter_decoded_messages():
            if channel.id not in counted:
                require(schema.encoding == "ros2msg", f"schema of {schema.encoding}")
                right = right_hash(schema.name, schema.data.decode())
                found = channel.metadata["topic_type_hash"]
                require({found} == right, f"{channel.topic}: {found}")
            counted[channel.id] = counted.get(channel.id, 0) + 1
            types[channel.topic] = schema.name
    require(dict(summary.statistics.channel_message_counts) == counted, "counts are wrong")
    require(summary.statistics.message_count == sum(counted.values()), "its count is wrong")
    require(len(summary.chunk_indexes) == summary.statistics.chunk_count, "chunks are missing")
    return types


def has_right_summary(checks, folder):
    for path in write_all_types(checks, folder, "mcap"):
        require(len(is_right_mcap(path)) >= 3, "too few topics")


# What a run shows of itself, beside the scans.
SHOWN = {
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/map": "nav_msgs/msg/OccupancyGrid",
    "/path": "nav_msgs/msg/Path",
    "/submaps": "visualization_msgs/msg/MarkerArray",
    "/verdict": "diagnostic_msgs/msg/DiagnosticArray",
}


def shows_a_run(checks, folder):
    checks.run("simulate", "office", "-o", folder / "sim", "--duration", "60")
    checks.run("map", folder / "sim", "-o", folder / "out", "--mcap", folder / "run.mcap")
    types = is_right_mcap(folder / "run.mcap")
    for topic, name in SHOWN.items():
        require(types.get(topic) == name, f"{topic} holds {types.get(topic)} instead of {name}")
    shown = readers.by_mcap(folder / "run.mcap").scans["/scan"]
    wanted = told_by_ucsd(folder / "sim").scans["/scan"]
    same_counts({"/scan": len(shown)}, {"/scan": len(wanted)})
    for found, scan in zip(shown, wanted):
        same_scan("/scan", found._replace(stamp_ns=scan.stamp_ns), scan)


def converts_by_rosbags(checks, folder, kind):
    for path in write_all_types(checks, folder, kind):
        target = (
            folder / f"{path.stem}_by_them" if kind == "bag" else folder / f"{path.stem}.them.bag"
        )
        tool = pathlib.Path(sys.executable).with_name("rosbags-convert")
        done = subprocess.run(
            [tool, "--src", path, "--dst", target], stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        )
        require(done.returncode == 0, f"rosbags-convert: {done.stdout.decode()[-1000:]}")
        same_counts(counts_in(checks, target), readers.counts_by_rosbags(path))
        compare(readers.by_rosbags(target), readers.by_rosbags(path))


def check_what_we_write(checks):
    messages = drive(scans=80)
    for kind in WRITTEN:
        checks(f"written: {kind} of a drive", converted, kind, messages, expected(messages))
        checks(f"written: {kind} by simulate", simulated, kind)
    checks("written: md5 and definitions of a bag", has_right_md5)
    checks("written: hashes, durability and metadata.yaml of rosbag2", has_right_hashes)
    checks("written: hashes and summary of mcap", has_right_summary)
    checks("written: mcap of a run, by map", shows_a_run)
    for kind in ("bag", "rosbag2"):
        checks(f"written: {kind} through rosbags-convert", converts_by_rosbags, kind)


# Cut and damaged.


def finds_no_less(checks, path, least):
    """Even where messages are few: a log that is nearly empty is an error, with its reasons."""
    require(least > 0, "the reference reader finds nothing: nothing is compared")
    found = sum(counts_in(checks, path).values())
    require(found >= least, f"{found} messages, where the reference reader finds {least}")


def cut(source, target, share):
    content = source.read_bytes()
    target.write_bytes(content[: int(share * len(content))])


def cut_mcap(checks, folder, options, share):
    writers.write_mcap(folder / "whole.mcap", drive(), **options)
    cut(folder / "whole.mcap", folder / "cut.mcap", share)
    finds_no_less(checks, folder / "cut.mcap", readers.count_mcap(folder / "cut.mcap"))


def spoilt_mcap(checks, folder, options, at_share):
    """Bytes in the middle are wrong; what stands before and behind is still there."""
    messages = drive()
    path = folder / "spoilt.mcap"
    writers.write_mcap(path, messages, **options)
    content = bytearray(path.read_bytes())
    at = int(at_share * len(content))
    content[at : at + 64] = bytes(64)
    path.write_bytes(content)
    finds_no_less(checks, path, max(readers.count_mcap(path), int(0.75 * len(messages))))


def index_of_bag(path):
    with Reader1(path) as reader:
        return sorted(reader.chunk_infos, key=lambda chunk: chunk.pos)


def cut_bag(checks, folder, packing, share):
    """As a recorder that was killed leaves it: without an index, the last chunk in pieces. The
    reference reader wants an index; it has told before which chunks are still whole."""
    writers.write_bag(folder / "whole.bag", drive(), packing)
    chunks = index_of_bag(folder / "whole.bag")
    size = (folder / "whole.bag").stat().st_size
    end = int(share * size)
    whole = [a for a, b in zip(chunks, chunks[1:]) if b.pos <= end]
    require(len(chunks) > 5, "the bag has too few chunks to be cut")
    path = folder / "cut.bag.active"
    content = bytearray((folder / "whole.bag").read_bytes()[:end])
    at = content.index(b"index_pos=") + len(b"index_pos=")
    content[at : at + 8] = bytes(8)
    path.write_bytes(content)
    finds_no_less(checks, path, sum(sum(chunk.connection_counts.values()) for chunk in whole))


def cut_rosbag2(checks, folder, share):
    """SQLite itself tells how many rows can still be read from the beginning."""
    writers.write_rosbag2(folder / "whole", drive())
    (folder / "cut").mkdir()
    path = folder / "cut/cut_0.db3"
    cut(writers.database_of(folder / "whole"), path, share)
    least = 0
    database = sqlite3.connect(path)
    try:
        for _ in database.execute("SELECT data FROM messages ORDER BY id"):
            least += 1
    except sqlite3.Error:
        pass
    database.close()
    finds_no_less(checks, folder / "cut", max(least, int(0.5 * share * len(drive()))))


def check_damage(checks):
    for packing, options in writers.MCAP_PACKINGS.items():
        for share in (0.3, 0.61, 0.9, 0.999):
            checks(f"cut: mcap, {packing}, at {share}", cut_mcap, options, share)
        for share in (0.35, 0.7):
            checks(f"damaged: mcap, {packing}, at {share}", spoilt_mcap, options, share)
    for packing in (None, "bz2", "lz4"):
        for share in (0.3, 0.61, 0.9):
            checks(f"cut: bag, {packing or 'plain'}, at {share}", cut_bag, packing, share)
    for share in (0.5, 0.9):
        checks(f"cut: rosbag2, at {share}", cut_rosbag2, share)


# Recorded.


def has_all_messages(checks, folder, path):
    try:
        wanted = readers.counts_by_rosbags(path)
    except AssertionError:  # an index that it does not take
        wanted = readers.counts_by_foxglove(path)
    same_counts(counts_in(checks, path), wanted)


def has_all_of_mcap(checks, folder, path):
    with open(path, "rb") as stream:
        summary = readers.SeekingReader(stream).get_summary()
    counts = {channel.topic: 0 for channel in summary.channels.values()}
    for number, count in summary.statistics.channel_message_counts.items():
        counts[summary.channels[number].topic] += count
    same_counts(counts_in(checks, path), counts)


def has_all_scans(checks, folder, path, all_scans):
    """Every laser by itself, by the stamps of its messages: ranges as rosbags reads them."""
    for number, (topic, scans) in enumerate(all_scans.items()):
        out = folder / f"{number}.mcap"
        named = ("--topic", f"laser={topic}", "--stamps", "header")
        checks.run("convert", path, out, *named)
        found = readers.by_mcap(out).scans.get("/scan", [])
        wanted = sorted(scans, key=lambda scan: scan.stamp_ns)
        same_stamps(topic, [s.stamp_ns for s in found], [s.stamp_ns for s in wanted])
        for a, b in zip(found, wanted):
            ranges = by_convention(b.ranges, b.range_min, b.range_max)
            require(
                np.array_equal(a.ranges, ranges, equal_nan=True),
                f"{topic} at {b.stamp_ns}: ranges {a.ranges[:20]} instead of {ranges[:20]}",
            )


def comes_out_the_same(checks, folder, one, other):
    checks.run("convert", one, folder / "one.mcap")
    checks.run("convert", other, folder / "other.mcap")
    compare(readers.by_mcap(folder / "one.mcap"), readers.by_mcap(folder / "other.mcap"))


def check_recorded(checks):
    data = pathlib.Path(os.environ.get("LOOPSTONE_DATA", ROOT.parent / "shared/data")) / "bags"
    if not data.is_dir():
        print(f"skipped: recorded bags, which are not in {data}")
        return
    for path in sorted(data.glob("*.bag")):
        checks(f"recorded: {path.name}", has_all_messages, path)
        scans = readers.scans_by_rosbags(path)
        if scans:
            checks(f"recorded: scans of {path.name}", has_all_scans, path, scans)
    for path in sorted(data.glob("**/metadata.yaml")):
        checks(f"recorded: {path.parent.name}/", has_all_messages, path.parent)
    for path in sorted(data.glob("*.mcap")):
        checks(f"recorded: {path.name}", has_all_of_mcap, path)
    pair = (data / "trace0.bag", data / "ros2/trace0")
    if all(path.exists() for path in pair):
        checks("recorded: trace0 as bag and as rosbag2", comes_out_the_same, *pair)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/loopstone"))
    parser.add_argument("--only", default="", help="checks whose names hold this word")
    arguments = parser.parse_args()
    program = str(pathlib.Path(arguments.program).resolve())
    if not os.access(program, os.X_OK):
        sys.exit(f"{program} is not there: build it first")
    folder = pathlib.Path(tempfile.mkdtemp(prefix="oracles."))
    checks = Checks(program, folder, arguments.only)
    check_what_they_write(checks)
    check_what_we_write(checks)
    check_damage(checks)
    check_recorded(checks)
    if checks.failed == 0:
        shutil.rmtree(folder)
    print(f"{checks.passed} passed, {checks.failed} failed")
    sys.exit(0 if checks.failed == 0 and checks.passed > 0 else 1)


if __name__ == "__main__":
    main()
