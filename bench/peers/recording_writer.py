"""Writes a recording as a robot with a camera makes it, for bench/recordings.py.

  recording_writer.py CONTAINER DRIVE FILE SECONDS [MOST_BYTES]

CONTAINER is one of CONTAINERS below. DRIVE is the folder of a simulated drive: log.mcap of
`loopstone simulate`, and odometry.tum of `loopstone odometry` on it. In the order of time stand the
drive's scans with intensities, its IMU, the odometry with tf, and pictures of a camera, which are
most of the bytes. It ends after SECONDS of the drive, or as soon as the file has MOST_BYTES. Needs
the reference libraries of tests/oracles (scripts/install_oracles.sh). Prints one JSON object.
"""
import heapq
import json
import os
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests/oracles"))

import numpy as np  # noqa: E402
from drive import Message, header  # noqa: E402
from mcap.reader import make_reader  # noqa: E402
from mcap.writer import CompressionType  # noqa: E402
from mcap.writer import Writer as McapWriter  # noqa: E402
from rosbags.rosbag1 import Writer as Writer1  # noqa: E402
from rosbags.rosbag2 import StoragePlugin  # noqa: E402
from rosbags.rosbag2 import Writer as Writer2  # noqa: E402
from writers import Encoder, plain, ros2_store, type2  # noqa: E402

CONTAINERS = ["bag", "bag-lz4", "bag-bz2", "mcap", "mcap-lz4", "mcap-zstd", "rosbag2"]
CHUNK_BYTES = 768 * 1024  # as both recorders of ROS have it
WIDTH, HEIGHT, CHANNELS = 640, 480, 3
PICTURE_HZ = 15
ODOMETRY_HZ = 50
PICTURES = 16  # that differ by more than where they begin
NOISE = 5.0  # standard deviation of a pixel; zstd leaves about half of such pictures
FLAT_SHARE = 0.25  # of the rows: over-exposed, of one colour
LARGEST_INTENSITY = 4000.0


def scan_with_intensities(scan, rng):
    """Near and bright, with noise, in whole numbers, as a scanner gives them."""
    ranges = np.asarray(scan["ranges"], dtype=np.float32)
    near = np.where(np.isfinite(ranges), 1.0 / (1.0 + 0.1 * ranges), 0.0)
    noise = rng.normal(1.0, 0.05, ranges.size)
    intensities = np.rint(LARGEST_INTENSITY * near * noise).astype(np.float32)
    return {**scan, "ranges": ranges, "intensities": intensities}


def drive_messages(log):
    """The drive as it is, but for the intensities and the wheels."""
    store, rng = ros2_store(), np.random.default_rng(1)
    wanted = {"/scan": "sensor_msgs/LaserScan", "/imu/data": "sensor_msgs/Imu"}
    wanted["/tf_static"] = "tf2_msgs/TFMessage"
    with open(log, "rb") as stream:
        for _, channel, record in make_reader(stream).iter_messages(topics=list(wanted)):
            kind = wanted[channel.topic]
            values = store.deserialize_cdr(record.data, type2(kind))
            if channel.topic == "/scan":
                values = {name: getattr(values, name) for name in values.__dataclass_fields__}
                values.pop("__msgtype__", None)
                values = scan_with_intensities({**values, "header": plain(values["header"])}, rng)
            else:
                values = plain(values)
            yield Message(channel.topic, kind, record.log_time, values)


def odometry_messages(tum):
    """At its own rate between the poses of the file."""
    poses = np.loadtxt(tum)
    yaws = np.unwrap(2.0 * np.arctan2(poses[:, 6], poses[:, 7]))
    stamps_s = np.arange(poses[0, 0], poses[-1, 0], 1.0 / ODOMETRY_HZ)
    between = [np.interp(stamps_s, poses[:, 0], of) for of in (poses[:, 1], poses[:, 2], yaws)]
    for stamp_s, x, y, yaw in zip(stamps_s, *between):
        stamp_ns = round(1e9 * stamp_s)
        rotation = {"x": 0.0, "y": 0.0, "z": np.sin(yaw / 2), "w": np.cos(yaw / 2)}
        place = {"x": x, "y": y, "z": 0.0}
        odometry = {
            "header": header(stamp_ns, "odom"),
            "child_frame_id": "base_link",
            "pose": {"pose": {"position": place, "orientation": rotation}},
        }
        moved = {
            "header": header(stamp_ns, "odom"),
            "child_frame_id": "base_link",
            "transform": {"translation": place, "rotation": rotation},
        }
        yield Message("/odom", "nav_msgs/Odometry", stamp_ns, odometry)
        yield Message("/tf", "tf2_msgs/TFMessage", stamp_ns, {"transforms": [moved]})


def pictures(rng):
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH]
    flat_rows = round(FLAT_SHARE * HEIGHT)
    for _ in range(PICTURES):
        shade = 100.0 + 10.0 * np.sin(0.01 * rows + 0.02 * columns + rng.uniform(0.0, 6.0))
        picture = shade[:, :, None] + rng.normal(0.0, NOISE, (HEIGHT, WIDTH, CHANNELS))
        picture[:flat_rows] = 255.0
        yield np.clip(picture, 0.0, 255.0).astype(np.uint8).reshape(-1)


def picture_messages(first_ns):
    some = list(pictures(np.random.default_rng(2)))
    number = 0
    while True:
        stamp_ns = first_ns + number * 10**9 // PICTURE_HZ
        row_bytes = WIDTH * CHANNELS
        image = {
            "header": header(stamp_ns, "camera"),
            "height": HEIGHT,
            "width": WIDTH,
            "encoding": "rgb8",
            "step": row_bytes,
            "data": np.roll(some[number % PICTURES], number * row_bytes),
        }
        yield Message("/camera/image_raw", "sensor_msgs/Image", stamp_ns, image)
        number += 1


def recording(drive, seconds):
    """Of endless pictures as many as the drive has time for."""
    others = heapq.merge(
        drive_messages(drive / "log.mcap"),
        odometry_messages(drive / "odometry.tum"),
        key=lambda message: message.recorded_ns,
    )
    first = next(others)
    yield first
    seen = picture_messages(first.recorded_ns)
    picture = next(seen)
    for message in others:
        if message.recorded_ns > first.recorded_ns + 1e9 * seconds:
            return
        while picture.recorded_ns <= message.recorded_ns:
            yield picture
            picture = next(seen)
        yield message


class Bag:
    def __init__(self, path, packing):
        self.encoder = Encoder("ros1")
        self.writer = Writer1(path)
        self.writer.chunk_threshold = CHUNK_BYTES
        if packing:
            self.writer.set_compression(Writer1.CompressionFormat[packing.upper()])
        self.writer.open()

    def add_topic(self, message):
        return self.writer.add_connection(
            message.topic,
            type2(message.type),
            typestore=self.encoder.store,
            latching=1 if message.topic == "/tf_static" else None,
        )

    def write(self, topic, message, data):
        self.writer.write(topic, message.recorded_ns, data)

    def close(self):
        self.writer.close()


class Rosbag2(Bag):
    def __init__(self, path):
        self.encoder = Encoder("cdr")
        self.writer = Writer2(path, version=9, storage_plugin=StoragePlugin.SQLITE3)
        self.writer.open()

    def add_topic(self, message):
        return self.writer.add_connection(
            message.topic, type2(message.type), typestore=self.encoder.store
        )


class Mcap:
    def __init__(self, path, packing):
        self.encoder = Encoder("cdr")
        self.writer = McapWriter(
            str(path),
            chunk_size=CHUNK_BYTES,
            compression=CompressionType[packing.upper() or "NONE"],
        )
        self.writer.start(profile="ros2", library="loopstone bench")

    def add_topic(self, message):
        schema = self.writer.register_schema(
            type2(message.type), "ros2msg", self.encoder.definition(message.type).encode()
        )
        return self.writer.register_channel(message.topic, "cdr", schema)

    def write(self, topic, message, data):
        stamp_ns = message.recorded_ns
        self.writer.add_message(topic, log_time=stamp_ns, publish_time=stamp_ns, data=data)

    def close(self):
        self.writer.finish()


def container_of(name, path):
    kind, _, packing = name.partition("-")
    if kind == "rosbag2":
        return Rosbag2(path)
    return (Bag if kind == "bag" else Mcap)(path, packing)


def write(name, drive, path, seconds, most_bytes):
    container = container_of(name, path)
    topics, counts, message_bytes = {}, {}, 0
    for message in recording(drive, seconds):
        if message.topic not in topics:
            topics[message.topic] = container.add_topic(message)
        data = container.encoder.bytes_of(message)
        container.write(topics[message.topic], message, data)
        counts[message.topic] = counts.get(message.topic, 0) + 1
        message_bytes += len(data)
        is_picture = message.topic.startswith("/camera")
        if most_bytes and is_picture and os.stat(path).st_size >= most_bytes:
            break
    container.close()
    return {"messages": counts, "message_bytes": message_bytes}


def main():
    if len(sys.argv) not in (5, 6):
        sys.exit(__doc__)
    name, drive, path, seconds = sys.argv[1:5]
    most_bytes = int(sys.argv[5]) if len(sys.argv) > 5 else 0
    written = write(name, pathlib.Path(drive), pathlib.Path(path), float(seconds), most_bytes)
    print(json.dumps(written))


if __name__ == "__main__":
    main()
