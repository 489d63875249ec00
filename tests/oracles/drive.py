"""A short drive as messages of ROS, the same every time, and what a reader of logs should make of
it. Values are plain dictionaries: each library makes its own messages of them."""
import math
from typing import NamedTuple

import numpy as np

START_NS = 1_700_000_000_123_456_789
# From the sensor to the recorder.
LATE_NS = 3_000_017
REAR_YAW = math.radians(170.0)


class Message(NamedTuple):
    topic: str
    type: str  # "sensor_msgs/LaserScan"
    recorded_ns: int
    values: dict


def header(stamp_ns, frame):
    return {"stamp": {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9}, "frame_id": frame}


def turn(yaw):
    return {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}


def transform(stamp_ns, parent, child, x, y, z, yaw):
    return {
        "header": header(stamp_ns, parent),
        "child_frame_id": child,
        "transform": {"translation": {"x": x, "y": y, "z": z}, "rotation": turn(yaw)},
    }


def ranges_of(number, beams):
    """Walls, and all that stands for no wall."""
    ranges = 3.0 + np.sin(0.1 * np.arange(beams) + 0.3 * number)
    ranges[::17] = np.inf
    ranges[1::17] = np.nan
    ranges[2::17] = 0.0
    ranges[3::17] = 0.02
    ranges[4::17] = 25.0
    ranges[5::17] = -1.0
    ranges[6::17] = -np.inf
    return ranges.astype(np.float32)


def scan(stamp_ns, frame, number, beams):
    step = np.float32(math.radians(0.75))
    first = np.float32(-0.5 * float(step) * (beams - 1))
    ranges = ranges_of(number, beams)
    return {
        "header": header(stamp_ns, frame),
        "angle_min": first,
        "angle_max": np.float32(float(first) + (beams - 1) * float(step)),
        "angle_increment": step,
        "time_increment": np.float32(1e-4),
        "scan_time": np.float32(0.1),
        "range_min": np.float32(0.05),
        "range_max": np.float32(20.0),
        "ranges": ranges,
        "intensities": (ranges * 10).astype(np.float32),
    }


def scans_of(topic, frame, shift_ns, period_ns, count, beams):
    for i in range(count):
        stamp_ns = START_NS + shift_ns + i * period_ns + 1_000 * (i % 7)
        yield Message(
            topic,
            "sensor_msgs/LaserScan",
            stamp_ns + LATE_NS,
            scan(stamp_ns, frame, i + len(frame), beams),
        )


def odometry_of(count):
    for i in range(count):
        stamp_ns = START_NS + i * 20_000_003
        x, y, yaw = 0.01 * i, 0.1 * math.sin(0.05 * i), 0.02 * i
        yield Message(
            "/odom",
            "nav_msgs/Odometry",
            stamp_ns + LATE_NS,
            {
                "header": header(stamp_ns, "odom"),
                "child_frame_id": "base_link",
                "pose": {"pose": {"position": {"x": x, "y": y}, "orientation": turn(yaw)}},
                "twist": {"twist": {"linear": {"x": 0.5}}},
            },
        )
        yield Message(
            "/tf",
            "tf2_msgs/TFMessage",
            stamp_ns + LATE_NS + 1,
            {"transforms": [transform(stamp_ns, "odom", "base_link", x, y, 0.0, yaw)]},
        )


def imu_of(count):
    for i in range(count):
        stamp_ns = START_NS + i * 10_000_001
        yield Message(
            "/imu/data",
            "sensor_msgs/Imu",
            stamp_ns + LATE_NS,
            {
                "header": header(stamp_ns, "imu_link"),
                "orientation": turn(0.0),
                "angular_velocity": {"x": 0.001 * i, "y": -0.002, "z": 0.1 + 1e-5 * i},
                "linear_acceleration": {"x": 0.2, "y": 0.01 * (i % 5), "z": 9.81},
            },
        )


def drive(scans=40):
    """All messages, in the order of the recorder: two lasers that look ahead and back, odometry,
    an IMU, tf, and words that mean nothing here."""
    fixed = [
        transform(START_NS, "base_link", "front_laser", 0.25, 0.0, 0.3, 0.0),
        transform(START_NS, "base_link", "rear_laser", -0.25, 0.125, 0.3, REAR_YAW),
        transform(START_NS, "base_link", "imu_link", 0.0, 0.0, 0.1, 0.0),
    ]
    messages = [Message("/tf_static", "tf2_msgs/TFMessage", START_NS, {"transforms": fixed})]
    messages += scans_of("/front/scan", "front_laser", 7_000_000, 100_000_000, scans, 271)
    messages += scans_of("/rear/scan", "rear_laser", 41_000_000, 66_666_667, scans, 181)
    messages += odometry_of(5 * scans)
    messages += imu_of(10 * scans)
    for i in range(scans):
        text = f"message {i} of nobody's interest"
        messages.append(
            Message("/words", "std_msgs/String", START_NS + i * 90_000_001, {"data": text})
        )
    return sorted(messages, key=lambda message: message.recorded_ns)


def counts_of(messages):
    counts = {}
    for message in messages:
        counts[message.topic] = counts.get(message.topic, 0) + 1
    return counts


# What a recording says, whoever wrote or read it: one shape for all comparisons.


class Scan(NamedTuple):
    stamp_ns: int
    angle_min: float
    angle_increment: float
    time_increment: float
    range_min: float
    range_max: float
    ranges: np.ndarray


class Told(NamedTuple):
    scans: dict  # by topic
    poses: list  # (stamp_ns, x, y, yaw)
    imu: list  # (stamp_ns, angular velocity, linear acceleration)
    mounts: dict  # frame: (x, y, z, yaw)
    ticks: list  # (stamp_ns, counts)


def by_convention(ranges, low, high):
    """+inf: nothing within reach; NaN: bad."""
    values = np.array(ranges, dtype=np.float32)
    far = values >= np.float32(high)
    bad = ~far & ~(values >= np.float32(low))
    values[far] = np.inf
    values[bad] = np.nan
    return values


def expected(messages):
    """What Loopstone should write of these messages: its own names of topics and frames, ranges by
    its own convention, intensities left out."""
    names = {"/front/scan": "/scan", "/rear/scan": "/scan_2"}
    frames = {"front_laser": "laser", "rear_laser": "laser_2"}
    told = Told({}, [], [], {}, [])
    for message in messages:
        values = message.values
        if message.topic in names:
            ranges = by_convention(values["ranges"], values["range_min"], values["range_max"])
            told.scans.setdefault(names[message.topic], []).append(
                Scan(
                    stamp_of(values["header"]["stamp"]),
                    *(
                        float(values[name])
                        for name in (
                            "angle_min",
                            "angle_increment",
                            "time_increment",
                            "range_min",
                            "range_max",
                        )
                    ),
                    ranges,
                )
            )
        elif message.topic == "/odom":
            pose = values["pose"]["pose"]
            told.poses.append(
                (
                    stamp_of(values["header"]["stamp"]),
                    pose["position"]["x"],
                    pose["position"]["y"],
                    yaw_of(pose["orientation"]["z"], pose["orientation"]["w"]),
                )
            )
        elif message.topic == "/imu/data":
            told.imu.append(
                (
                    stamp_of(values["header"]["stamp"]),
                    tuple(values["angular_velocity"].values()),
                    tuple(values["linear_acceleration"].values()),
                )
            )
        elif message.topic == "/tf_static":
            for fixed in values["transforms"]:
                if fixed["child_frame_id"] not in frames:
                    continue
                place, rotation = fixed["transform"]["translation"], fixed["transform"]["rotation"]
                told.mounts[frames[fixed["child_frame_id"]]] = (
                    place["x"],
                    place["y"],
                    place["z"],
                    yaw_of(rotation["z"], rotation["w"]),
                )
    return told


def stamp_of(stamp):
    return stamp["sec"] * 10**9 + stamp["nanosec"]


def yaw_of(z, w):
    return math.remainder(2.0 * math.atan2(z, w), 2.0 * math.pi)
