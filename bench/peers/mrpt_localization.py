"""MRPT's pf-localization (Debian: mrpt-apps) in a process of its own, with the configuration of its
demonstration. It reads a rawlog and a gridmap, which are written here, and tells its pose at every
scan in its messages.

Layouts: MRPT, libs/obs and libs/maps; docs/formats.md has that of the rawlog."""
import math
import re
import shutil
import struct

# Of the program's localization_demo.ini, without what is of that demonstration alone.
CONFIGURATION = """\
[KLD_options]
KLD_binSize_PHI_deg = 10
KLD_binSize_XY = 0.10
KLD_delta = 0.01
KLD_epsilon = 0.01
KLD_maxSampleSize = {particles}
KLD_minSampleSize = 150
KLD_minSamplesPerBin = 0
[PF_options]
PF_algorithm = 0
resamplingMethod = 0
adaptiveSampleSize = 1
pfAuxFilterOptimal_MaximumSearchSamples = 10
BETA = 0.5
sampleSize = 1
[LocalizationExperiment]
use_3D_poses = false
map_file = map.gridmap
rawlog_file = log.rawlog
logOutput_dir = out
3DSceneFrequency = -1
experimentRepetitions = 1
particles_count = {particles}
init_PDF_mode = {mode}
init_PDF_min_x = {x0}
init_PDF_max_x = {x1}
init_PDF_min_y = {y0}
init_PDF_max_y = {y1}
init_PDF_min_yaw_deg = {yaw0}
init_PDF_max_yaw_deg = {yaw1}
SHOW_PROGRESS_3D_REAL_TIME = false
[MetricMap]
occupancyGrid_count = 1
gasGrid_count = 0
landmarksMap_count = 0
pointsMap_count = 0
beaconMap_count = 0
likelihoodMapSelection = -1
enableInsertion_gridMaps = 1
[MetricMap_occupancyGrid_00_creationOpts]
resolution = {resolution}
"""
# A file of a gridmap overrules the configuration, so they stand in it.
LIKELIHOOD = {"decimation": 20, "std_hit_m": 0.2, "z_hit": 0.95, "z_random": 0.05}
MAX_RANGE_M, MAX_PAIR_DISTANCE_M, LIKELIHOOD_FIELD = 80.0, 0.3, 4
PARTICLES = 40000
END = b"\x88"
# Of a probability as an odd in a byte: sure to be free, unknown, sure to be occupied.
ODDS = bytes([127, 0, 129])
TICKS_TO_1970 = 116_444_736_000_000_000
ESTIMATE = re.compile(
    r"PDF estimation: \(?\[?\s*([-+.\deE]+)[ ,]+([-+.\deE]+)[ ,]+([-+.\deE]+)\s*deg.*"
    r"tr\(cov\): (\S+)"
)


def is_here():
    return shutil.which("pf-localization") is not None


def begin(name, version):
    return bytes([0x80 + len(name)]) + name.encode() + bytes([version])


def pose2(x, y, yaw):
    return begin("CPose2D", 1) + struct.pack("<3d", x, y, yaw) + END


def motion(increment, ticks):
    """Odometry's increment, with the model of its noise that MRPT has where nothing is said."""
    gaussian = (0.01, math.degrees(0.001), math.radians(1.0), 0.05, 0.01, math.radians(0.2))
    thrun = (0.05, math.radians(4.0), 0.01, math.degrees(0.0001), 0.001, math.radians(0.05))
    return (
        begin("CActionCollection", 0)
        + struct.pack("<I", 1)
        + begin("CActionRobotMovement2D", 6)
        + struct.pack("<I", 0)
        + pose2(*increment)
        + struct.pack("<i6fi6f", 0, *gaussian, 300, *thrun)
        + struct.pack("<BffBiiQ", 0, 0.0, 0.0, 0, 0, 0, ticks)
        + END
        + END
    )


def frame(scan, robot_T_laser, ticks):
    """A sensory frame of one scan; MRPT's beams lie evenly about the laser's axis, so the axis is
    the middle of them."""
    count = len(scan.ranges_m)
    aperture = scan.step_rad * (count - 1)
    x, y, yaw = robot_T_laser
    yaw += scan.angle_rad + 0.5 * aperture
    pose = begin("CPose3D", 2)
    pose += struct.pack("<7d", x, y, 0.0, math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw)) + END
    valid = bytes(range_m < scan.range_max_m for range_m in scan.ranges_m)
    return (
        begin("CSensoryFrame", 2)
        + struct.pack("<I", 1)
        + begin("CObservation2DRangeScan", 6)
        + struct.pack("<fBf", aperture, 1, scan.range_max_m)
        + pose
        + struct.pack(f"<I{count}f", count, *scan.ranges_m)
        + valid
        + struct.pack("<fQfI5sd", 0.01, ticks, 0.0, 5, b"laser", 0.0)
        + END
        + END
    )


def increment_of(before, now):
    """before^-1 * now."""
    x, y, turn = (b - a for a, b in zip(before, now))
    c, s = math.cos(before[2]), math.sin(before[2])
    return c * x + s * y, c * y - s * x, math.remainder(turn, 2.0 * math.pi)


def write_rawlog(feed, path):
    with open(path, "wb") as file:
        before = feed.scans[0].odom_T_robot
        for scan in feed.scans:
            ticks = TICKS_TO_1970 + round(1e7 * float(scan.stamp))
            file.write(motion(increment_of(before, scan.odom_T_robot), ticks))
            file.write(frame(scan, feed.robot_T_laser, ticks))
            before = scan.odom_T_robot


def write_gridmap(cells, path):
    """Its lower left corner is the origin: MRPT rounds where a map begins to whole cells."""
    width_m, height_m = cells.size_m
    path.write_bytes(
        begin("COccupancyGridMap2D", 3)
        + struct.pack("<BII", 8, cells.width, cells.height)
        + struct.pack("<5f", 0.0, width_m, 0.0, height_m, cells.resolution_m)
        + cells.states.translate(ODDS + bytes(253))
        # What is inserted into the map, which nothing is.
        + struct.pack("<fBffBHf", 0.0, 0, 15.0, 0.55, 1, 1, math.radians(0.05))
        + struct.pack("<i", LIKELIHOOD_FIELD)
        + struct.pack("<3f", *(LIKELIHOOD[key] for key in ("std_hit_m", "z_hit", "z_random")))
        + struct.pack("<fIfB", MAX_RANGE_M, LIKELIHOOD["decimation"], MAX_PAIR_DISTANCE_M, 0)
        # The other methods, which are not used.
        + struct.pack("<fIfBifIf", 10.0, 10, 2.0, 0, 10, 0.3, 30, 1.0)
        + struct.pack("<IBB", 0, 1, 0)
        + END
    )


class PfLocalization:
    """Writes the files once (not counted); then follows the robot as often as asked. It can't be
    given a seed: it takes one from the clock."""

    def __init__(self, feed):
        self.feed, self.folder = feed, feed.work / "mrpt"
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        write_rawlog(feed, self.folder / "log.rawlog")
        write_gridmap(feed.cells, self.folder / "map.gridmap")

    def configure(self, start):
        cells = self.feed.cells
        values = {"particles": PARTICLES, "resolution": cells.resolution_m}
        if start:  # a box of the same variance: it knows no other start
            x, y, yaw, sigma_m, sigma_rad = start
            half_m = math.sqrt(3.0) * sigma_m
            half_deg = math.degrees(math.sqrt(3.0) * sigma_rad)
            x, y, yaw_deg = x - cells.x_m, y - cells.y_m, math.degrees(yaw)
            values |= {"mode": 1, "x0": x - half_m, "x1": x + half_m, "y0": y - half_m}
            values |= {"y1": y + half_m, "yaw0": yaw_deg - half_deg, "yaw1": yaw_deg + half_deg}
        else:
            width_m, height_m = cells.size_m
            values |= {"mode": 0, "x0": 0.0, "x1": width_m, "y0": 0.0, "y1": height_m}
            values |= {"yaw0": -180.0, "yaw1": 180.0}
        (self.folder / "pf.ini").write_text(CONFIGURATION.format(**values))

    def localize(self, run, start):
        """As Amcl.localize."""
        self.configure(start)
        output, cost = run(
            ["sh", "-c", 'exec "$@" </dev/null 2>&1', "sh", "pf-localization", "pf.ini"],
            folder=self.folder,
        )
        found = [tuple(map(float, words)) for words in ESTIMATE.findall(output)]
        if len(found) != len(self.feed.scans):
            raise RuntimeError(
                f"pf-localization told {len(found)} poses of {len(self.feed.scans)} scans"
            )
        x0, y0 = self.feed.cells.x_m, self.feed.cells.y_m
        rows = [
            (scan.stamp, x + x0, y + y0, math.radians(yaw), spread)
            for scan, (x, y, yaw, spread) in zip(self.feed.scans, found)
        ]
        return rows, cost
