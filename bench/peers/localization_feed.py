"""What the peers of localisation are given, all of them the same: each scan of a log with
odometry's pose at its stamp, and the map as cells."""
import array
import dataclasses
import math
import re

from map_cells import cells_of

NO_RANGE_M = 0.05  # what is nearer is no return
CARMEN_STEPS_DEG = {180: 1.0, 181: 1.0, 360: 0.5, 361: 0.5, 400: 0.25, 401: 0.25}


@dataclasses.dataclass
class Scan:
    stamp: str
    odom_T_robot: tuple
    range_max_m: float
    angle_rad: float  # of the first beam, in the laser's frame
    step_rad: float
    ranges_m: array.array  # range_max_m: no return


def mount_of(robot_file):
    """robot_T_laser of the first laser in a robot's file."""
    laser = robot_file.read_text().split("[[lidars]]")[1]
    return tuple(
        float(re.search(rf"^{key}\s*=\s*(\S+)", laser, re.M).group(1))
        for key in ("x_m", "y_m", "yaw_rad")
    )


def beams_of(words):
    """Ranges, angle of the first beam, step and greatest range (or None) of a line of CARMEN."""
    if words[0] == "FLASER":
        count = int(words[1])
        step = math.radians(CARMEN_STEPS_DEG.get(count, 180.0 / max(count - 1, 1)))
        return array.array("d", map(float, words[2 : 2 + count])), -0.5 * math.pi, step, None
    count = int(words[8])
    ranges = array.array("d", map(float, words[9 : 9 + count]))
    return ranges, float(words[2]), float(words[4]), float(words[5])


def scans_of(carmen, odometry):
    """The scans of a CARMEN text that odometry has a pose for, by stamp."""
    scans, range_max_m = [], None
    with open(carmen, encoding="utf-8") as lines:
        for line in lines:
            words = line.split()
            if words and words[0] == "PARAM" and words[1] == "robot_front_laser_max":
                range_max_m = float(words[2])
            if not words or words[0] not in ("FLASER", "ROBOTLASER1"):
                continue
            stamp = words[-3]
            if stamp in odometry:
                ranges, angle, step, its_max = beams_of(words)
                scans.append(Scan(stamp, odometry[stamp], its_max, angle, step, ranges))
    if range_max_m is None:
        range_max_m = max(max(scan.ranges_m) for scan in scans)
    for scan in scans:
        scan.range_max_m = scan.range_max_m or range_max_m
        for i, range_m in enumerate(scan.ranges_m):
            if not NO_RANGE_M <= range_m < scan.range_max_m:
                scan.ranges_m[i] = scan.range_max_m
    return scans


def odometry_of(tum):
    poses = {}
    for line in tum.read_text().splitlines():
        words = line.split()
        yaw = 2.0 * math.atan2(float(words[6]), float(words[7]))
        poses[words[0]] = (float(words[1]), float(words[2]), yaw)
    return poses


class Feed:
    """Of a log and a map. The laser's mount and the wheels are as `loopstone calibrate` finds them,
    since the map was drawn with that."""

    def __init__(self, run, program, log, chart, work, duration_s=math.inf):
        """`run` as program.run; files go to `work`; of the log its first `duration_s`."""
        self.work = work
        work.mkdir(parents=True, exist_ok=True)
        carmen, robot, tum = work / "log.clf", work / "robot.toml", work / "odometry.tum"
        quiet = ["--force", "--quiet"]
        run([program, "convert", log, carmen, *quiet])
        run([program, "calibrate", log, "-o", robot, *quiet])
        run([program, "odometry", log, "-o", tum, "--robot", robot, *quiet])
        self.robot_T_laser = mount_of(robot)
        scans = scans_of(carmen, odometry_of(tum))
        end_s = float(scans[0].stamp) + duration_s
        self.scans = [scan for scan in scans if float(scan.stamp) <= end_s]
        self.cells = cells_of(chart)
        carmen.unlink()
