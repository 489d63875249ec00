#!/usr/bin/env python3
"""What bench/real_floor.py needs the libraries of build/oracles for: it runs this by their Python.

  real_floor_recording.py make DATA FOLDER [N]     the recorded frames (or number N of them) as a
                                                   recording, and where the camera was
  real_floor_recording.py seams FOLDER...          how far the textures of single frames lie beside
                                                   one another, as JSON
"""
import json
import math
import pathlib
import shutil
import sys
import zlib

import numpy as np
import yaml
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

LENS = (518.0, 519.0, 325.5, 253.5)
SIZE = (640, 480)
START_S, STEP_S = 1_700_000_000, 2


def rotation(q):
    x, y, z, w = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion(r):
    """x, y, z, w of a rotation matrix; any but half turns, which no camera here makes."""
    w = 0.5 * math.sqrt(max(1e-12, 1.0 + r[0, 0] + r[1, 1] + r[2, 2]))
    return [
        (r[2, 1] - r[1, 2]) / (4 * w),
        (r[0, 2] - r[2, 0]) / (4 * w),
        (r[1, 0] - r[0, 1]) / (4 * w),
        w,
    ]


def pose(r, t):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = r, t
    return matrix


def read_depth(path):
    """Metres, and the file's own bytes of them (16 bits, the upper half first)."""
    data = path.read_bytes()
    pixels = data[-2 * SIZE[0] * SIZE[1] :]
    return np.frombuffer(pixels, ">u2").reshape(SIZE[1], SIZE[0]) / 1000.0, pixels


def points_of(depth_m, every=4):
    fx, fy, cx, cy = LENS
    v, u = np.mgrid[0 : SIZE[1] : every, 0 : SIZE[0] : every]
    z = depth_m[v, u]
    seen = (z > 0.5) & (z < 5.0)
    z, u, v = z[seen], u[seen], v[seen]
    return np.stack([(u - cx) / fx * z, (v - cy) / fy * z, z], axis=1)


def floor_of(points, down):
    """Normal (up) and offset of the plane n . x = d with most points, among those across `down`."""
    random = np.random.default_rng(1)
    best, best_count = None, 0
    for _ in range(2000):
        a, b, c = points[random.integers(0, len(points), 3)]
        n = np.cross(b - a, c - a)
        if np.linalg.norm(n) < 1e-6:
            continue
        n /= np.linalg.norm(n)
        n = n if n @ down < 0 else -n
        if n @ down > -math.cos(math.radians(25)):
            continue
        count = np.sum(np.abs(points @ n - n @ a) < 0.02)
        # The floor has next to nothing below it, tables have.
        if np.mean(points @ n - n @ a < -0.10) < 0.02 and count > best_count:
            best, best_count = (n, n @ a), count
    n, d = best
    for _ in range(5):
        near = points[np.abs(points @ n - d) < 0.03]
        middle = near.mean(axis=0)
        n2 = np.linalg.svd(near - middle, full_matrices=False)[2][2]
        n = n2 if n2 @ down < 0 else -n2
        d = n @ middle
    return n, d


def floor_frame(cameras, points):
    """floor_T_world: z up from the floor, x where the first camera looks."""
    n, d = floor_of(points, cameras[0][:3, 1])
    forward = cameras[0][:3, 2] - (cameras[0][:3, 2] @ n) * n
    forward /= np.linalg.norm(forward)
    axes = np.stack([forward, np.cross(n, forward), n])
    origin = cameras[0][:3, 3] - (cameras[0][:3, 3] @ n - d) * n
    return pose(axes, -axes @ origin)


def make_recording(data, folder, only=None):
    """recording/ and trajectory.tum; run by the Python of build/oracles.

    only: the number of the one frame to write, its camera where it is among all."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    header = types["std_msgs/msg/Header"]
    time = types["builtin_interfaces/msg/Time"]
    cameras, clouds, depths = [], [], []
    lines = [line.split() for line in (data / "pose.txt").read_text().splitlines() if line.strip()]
    for i, line in enumerate(lines):
        numbers = np.array([float(word) for word in line])
        cameras.append(pose(rotation(numbers[3:]), numbers[:3]))
        depth_m, pixels = read_depth(data / f"depth{i + 1}.pgm")
        depths.append(pixels)
        points = points_of(depth_m)
        clouds.append(points @ cameras[i][:3, :3].T + cameras[i][:3, 3])
    floor_T_world = floor_frame(cameras, np.concatenate(clouds))

    bag = folder / "recording"
    shutil.rmtree(bag, ignore_errors=True)
    trajectory = []
    with Writer(bag, version=8, storage_plugin=StoragePlugin.MCAP) as writer:
        connections = {}

        def send(topic, kind, stamp_ns, message):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], stamp_ns, store.serialize_cdr(message, kind))

        def transform(stamp, parent, child, matrix):
            x, y, z, w = quaternion(matrix[:3, :3])
            return types["geometry_msgs/msg/TransformStamped"](
                header(stamp, parent),
                child,
                types["geometry_msgs/msg/Transform"](
                    types["geometry_msgs/msg/Vector3"](*map(float, matrix[:3, 3])),
                    types["geometry_msgs/msg/Quaternion"](x, y, z, w),
                ),
            )

        for i, camera in enumerate(cameras):
            if only not in (None, i):
                continue
            stamp_s = START_S + STEP_S * i
            stamp, stamp_ns = time(stamp_s, 0), stamp_s * 10**9
            floor_T_camera = floor_T_world @ camera
            yaw = math.atan2(floor_T_camera[1, 2], floor_T_camera[0, 2])
            c, s = math.cos(yaw), math.sin(yaw)
            base = pose(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]), [*floor_T_camera[:2, 3], 0])
            # The camera stood still while it took a picture.
            for dt_s in (-0.5, 0.0, 0.5):
                trajectory.append((stamp_s + dt_s, base[0, 3], base[1, 3], yaw))
            mount = np.linalg.inv(base) @ floor_T_camera
            tf = types["tf2_msgs/msg/TFMessage"]
            send(
                "/tf",
                "tf2_msgs/msg/TFMessage",
                stamp_ns,
                tf(
                    [
                        transform(stamp, "odom", "base_footprint", base),
                        transform(stamp, "base_footprint", "camera_optical", mount),
                    ]
                ),
            )
            head = header(stamp, "camera_optical")
            fx, fy, cx, cy = LENS
            region = types["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
            for topic in ("/camera/rgb/camera_info", "/camera/depth_registered/camera_info"):
                info = types["sensor_msgs/msg/CameraInfo"](
                    head,
                    SIZE[1],
                    SIZE[0],
                    "plumb_bob",
                    np.zeros(5),
                    np.array([fx, 0, cx, 0, fy, cy, 0, 0, 1.0]),
                    np.eye(3).ravel(),
                    np.array([fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1.0, 0]),
                    0,
                    0,
                    region,
                )
                send(topic, "sensor_msgs/msg/CameraInfo", stamp_ns, info)
            png = np.frombuffer((data / f"color{i + 1}.png").read_bytes(), np.uint8)
            send(
                "/camera/rgb/image_rect_color/compressed",
                "sensor_msgs/msg/CompressedImage",
                stamp_ns,
                types["sensor_msgs/msg/CompressedImage"](head, "rgb8; png compressed", png),
            )
            send(
                "/camera/depth_registered/image_rect",
                "sensor_msgs/msg/Image",
                stamp_ns,
                types["sensor_msgs/msg/Image"](
                    head,
                    SIZE[1],
                    SIZE[0],
                    "16UC1",
                    1,
                    2 * SIZE[0],
                    np.frombuffer(depths[i], np.uint8),
                ),
            )
    text = "".join(
        f"{t} {x:.6f} {y:.6f} 0 0 0 {math.sin(yaw / 2):.9f} {math.cos(yaw / 2):.9f}\n"
        for t, x, y, yaw in trajectory
    )
    (folder / "trajectory.tum").write_text(text)


def read_png(path):
    """Rows of red, green, blue, alpha; of the PNG pictures that Loopstone writes."""
    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        size, kind = int.from_bytes(data[at : at + 4], "big"), data[at + 4 : at + 8]
        if kind == b"IHDR":
            width = int.from_bytes(data[at + 8 : at + 12], "big")
            height = int.from_bytes(data[at + 12 : at + 16], "big")
        if kind == b"IDAT":
            packed += data[at + 8 : at + 8 + size]
        at += size + 12
    lines = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 4 * width + 1)
    rows = np.zeros((height + 1, width + 1, 4), int)
    for y in range(height):
        line = lines[y, 1:].reshape(width, 4).astype(int)
        left, above = rows[y + 1], rows[y]
        for x in range(width):
            a, b, c = left[x], above[x + 1], above[x]
            p = a + b - c
            pa, pb, pc = abs(p - a), abs(p - b), abs(p - c)
            paeth = np.where((pa <= pb) & (pa <= pc), a, np.where(pb <= pc, b, c))
            guess = (0, a, b, (a + b) // 2, paeth)[lines[y, 0]]
            left[x + 1] = (line[x] + guess) % 256
    return rows[1:, 1:]


def box_sum(values, reach):
    sums = np.pad(values, ((reach + 1, reach), (reach + 1, reach))).cumsum(0).cumsum(1)
    side = 2 * reach + 1
    return sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side]


def structure_of(folder):
    """What of the floor's brightness is neither shading nor noise, and where it was seen."""
    picture = read_png(folder / "texture.png").astype(float)
    frame = yaml.safe_load((folder / "texture.yaml").read_text())
    seen = picture[..., 3] > 0
    light = np.sqrt(picture[..., :3].mean(axis=2)) * seen
    shading = box_sum(light, 15) / np.maximum(box_sum(seen.astype(float), 15), 1)
    rest = (light - shading) * seen
    rest = box_sum(rest, 2) / np.maximum(box_sum(seen.astype(float), 2), 1)
    # Upside down, so that rows count from the origin.
    cells = [round(value / frame["resolution"]) for value in frame["origin"][:2]]
    return rest[::-1], seen[::-1], cells, frame["resolution"]


def seams(folders):
    """For each two frames the shift at which what both see of the floor correlates best."""
    most = 12
    views = [structure_of(pathlib.Path(folder)) for folder in folders]
    low = [min(view[2][axis] for view in views) - most for axis in (0, 1)]
    size = [
        max(view[2][axis] + view[0].shape[1 - axis] for view in views) - low[axis] + most
        for axis in (0, 1)
    ]
    common = []
    for rest, seen, (x, y), _ in views:
        place = np.s_[y - low[1] :, x - low[0] :]
        values, known = np.zeros((size[1], size[0])), np.zeros((size[1], size[0]), bool)
        values[place][: rest.shape[0], : rest.shape[1]] = rest
        known[place][: rest.shape[0], : rest.shape[1]] = seen
        common.append((values, known))
    found = []
    for a in range(len(common)):
        for b in range(a + 1, len(common)):
            best = (-1.0, 0, 0)
            for dy in range(-most, most + 1):
                for dx in range(-most, most + 1):
                    values, known = (np.roll(part, (dy, dx), (0, 1)) for part in common[b])
                    both = common[a][1] & known
                    if both.sum() < 3000:
                        continue
                    agreement = np.corrcoef(common[a][0][both], values[both])[0, 1]
                    best = max(best, (float(agreement), dx, dy))
            shift_m = math.hypot(best[1], best[2]) * views[a][3]
            found.append({"frames": [a, b], "shift_m": shift_m, "correlation": best[0]})
    return found


if __name__ == "__main__":
    if sys.argv[1] == "make":
        only = int(sys.argv[4]) if len(sys.argv) > 4 else None
        make_recording(pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]), only)
    else:
        print(json.dumps(seams(sys.argv[2:])))
