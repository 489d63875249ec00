"""What the reference libraries find in a recording, as drive.Told."""
import json
import pathlib
import subprocess
from types import SimpleNamespace

import numpy as np
from drive import Scan, Told, yaw_of
from mcap.reader import NonSeekingReader, SeekingReader
from mcap_ros1.decoder import DecoderFactory as Ros1Decoder
from mcap_ros2.decoder import DecoderFactory as Ros2Decoder
from rosbags.highlevel import AnyReader

MODULES = pathlib.Path(__file__).resolve().parent.parent.parent / "build/oracles/node_modules"


def stamp_of(message):
    stamp = message.header.stamp
    for name in ("nanosec", "nsec", "nsecs"):
        if hasattr(stamp, name):
            seconds = stamp.secs if name == "nsecs" else stamp.sec
            return int(seconds) * 10**9 + int(getattr(stamp, name))
    raise AssertionError(f"a stamp without nanoseconds: {stamp}")


def xyz(vector):
    return (float(vector.x), float(vector.y), float(vector.z))


def told(messages):
    """Of (topic, message) with fields as attributes, whichever library made them."""
    result = Told({}, [], [], {}, [])
    for topic, message in messages:
        if hasattr(message, "ranges"):
            names = ("angle_min", "angle_increment", "time_increment", "range_min", "range_max")
            numbers = (float(getattr(message, name)) for name in names)
            ranges = np.array([float(r) for r in message.ranges], dtype=np.float32)
            scan = Scan(stamp_of(message), *numbers, ranges)
            result.scans.setdefault(topic, []).append(scan)
        elif hasattr(message, "child_frame_id"):
            pose = message.pose.pose
            yaw = yaw_of(pose.orientation.z, pose.orientation.w)
            result.poses.append((stamp_of(message), pose.position.x, pose.position.y, yaw))
        elif hasattr(message, "angular_velocity"):
            result.imu.append(
                (stamp_of(message), xyz(message.angular_velocity), xyz(message.linear_acceleration))
            )
        elif hasattr(message, "counts"):
            counts = tuple(int(count) for count in message.counts)
            result.ticks.append((stamp_of(message), counts))
        elif topic == "/tf_static":
            for fixed in message.transforms:
                rotation = fixed.transform.rotation
                result.mounts[fixed.child_frame_id] = (
                    *xyz(fixed.transform.translation),
                    yaw_of(rotation.z, rotation.w),
                )
    return result


def by_rosbags(path):
    """Every message by the definitions that the recording has, none of them known before."""
    from rosbags.typesys import Stores, get_typestore

    with AnyReader([pathlib.Path(path)], default_typestore=get_typestore(Stores.EMPTY)) as reader:
        return told(
            (connection.topic, reader.deserialize(raw, connection.msgtype))
            for connection, _, raw in reader.messages()
        )


def scans_by_rosbags(path):
    """Of each topic of LaserScan; none where its index is not taken."""
    try:
        with AnyReader([pathlib.Path(path)]) as reader:
            lasers = [c for c in reader.connections if c.msgtype == "sensor_msgs/msg/LaserScan"]
            messages = reader.messages(connections=lasers) if lasers else ()
            return told(
                (c.topic, reader.deserialize(raw, c.msgtype)) for c, _, raw in messages
            ).scans
    except AssertionError:
        return {}


def by_mcap(path, is_seeking=True):
    with open(path, "rb") as stream:
        reader = (SeekingReader if is_seeking else NonSeekingReader)(
            stream, validate_crcs=True, decoder_factories=[Ros2Decoder(), Ros1Decoder()]
        )
        return told(
            (channel.topic, message)
            for _, channel, _, message in reader.iter_decoded_messages(log_time_order=is_seeking)
        )


def lines_of_foxglove(path):
    """What read_bag.js prints, a message at a time."""
    script = pathlib.Path(__file__).with_name("read_bag.js")
    done = subprocess.run(
        ["node", script, MODULES, path], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    if done.returncode != 0:
        raise AssertionError(f"@foxglove/rosbag: {done.stderr.decode()[-2000:]}")

    def objects(values):
        return SimpleNamespace(**values)

    for line in done.stdout.decode().splitlines():
        yield json.loads(line, object_hook=objects)


def by_foxglove(path):
    return told((line.topic, line.message) for line in lines_of_foxglove(path))


def counts_by_foxglove(path):
    counts = {}
    for line in lines_of_foxglove(path):
        counts[line.topic] = counts.get(line.topic, 0) + 1
    return counts


def count_mcap(path):
    """How many messages the reader gives before it gives up, at what is damaged or missing."""
    count = 0
    with open(path, "rb") as stream:
        try:
            for _ in NonSeekingReader(stream).iter_messages(log_time_order=False):
                count += 1
        except Exception:  # whatever it says of a file that was cut
            pass
    return count


def counts_by_rosbags(path):
    """Messages by topic, as its index and metadata say."""
    with AnyReader([pathlib.Path(path)]) as reader:
        counts = {}
        for connection in reader.connections:
            counts[connection.topic] = counts.get(connection.topic, 0) + connection.msgcount
        return counts
