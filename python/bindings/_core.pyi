"""The C++ library of Loopstone; `import loopstone` is what to use."""

from collections.abc import (
    Callable,
    Iterable,
    Iterator,
    Mapping,
    Sequence
)
import datetime
import os
from typing import Annotated, Any, Literal, overload

import matplotlib.axes
import networkx
import numpy
import numpy.typing
from numpy.typing import NDArray
import pandas

import loopstone._progress
import loopstone.options


version: str

class OptionValues:
    """What is to be other than by default; loopstone.options makes it."""

    def __init__(self, file: str = '', values: Sequence[tuple[str, str]] = []) -> None: ...

def describe_options(of: str) -> list[dict[str, Any]]:
    """
    Every option of a call: its dotted key, default, words, range, rule and help.
    """

def options_toml(of: str, values: OptionValues) -> str:
    """
    The effective options as TOML, as `loopstone config` prints them. Raises OptionsError.
    """

class Pose:
    """
    A rigid motion of the plane: where frame b lies in frame a, ``a_T_b``. Can't be changed.

    Poses are arrays (3,) elsewhere; this is for who computes with them. Whatever takes a pose
    takes one of these.
    """

    def __init__(self, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> None:
        """x, y [m], yaw [rad]. Raises ValueError for what is not finite."""

    @staticmethod
    def of(pose: numpy.typing.ArrayLike) -> Pose:
        """Of an array (3,): x, y, yaw. Raises ValueError."""

    @property
    def x(self) -> float:
        """[m]"""

    @property
    def y(self) -> float:
        """[m]"""

    @property
    def yaw(self) -> float:
        """[rad] counter-clockwise, in (-pi, pi]."""

    @property
    def matrix(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """(3, 3) of homogeneous coordinates."""

    @overload
    def __matmul__(self, arg: Pose, /) -> Pose:
        """``a_T_c = a_T_b @ b_T_c``."""

    @overload
    def __matmul__(self, points: numpy.typing.ArrayLike, /) -> numpy.typing.NDArray[numpy.float64]:
        """As :meth:`transform`."""

    def transform(self, points: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        (N, 2) or (2,) points of the pose's own frame, in the frame that it lies in [m]. Points that
        are not finite stay so. Raises ValueError for another shape.
        """

    def inverse(self) -> Pose:
        """``b_T_a`` of ``a_T_b``."""

    def between(self, other: Pose) -> Pose:
        """The other one as seen from here: ``self.inverse() @ other``."""

    def interpolate(self, other: Pose, ratio: float) -> Pose:
        """
        Along the arc to the other one: 0 is here, 1 is there; it goes on beyond both.
        """

    @staticmethod
    def exp(twist: numpy.typing.ArrayLike) -> Pose:
        """The motion along a twist (3,) [m, m, rad] for unit time: an arc."""

    @property
    def twist(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(3,) of which this is exp()."""

    def __len__(self) -> int: ...

    def __getitem__(self, index: int) -> float: ...

    def __iter__(self) -> Iterator[float]: ...

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> numpy.typing.NDArray[Any]: ...

    __array_ufunc__: None = None

    def __eq__(self, other: object, /) -> bool: ...

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

class LidarMount:
    """Where a planar lidar sits on the robot; can't be changed."""

    def __init__(self, x_m: float = 0.14, y_m: float = 0.0, yaw_rad: float = 0.0, *, height_m: float = 0.51435, upside_down: bool = False, sweep_s: float = 0.0, name: str = 'front') -> None:
        """
        By default that of the UCSD robot. Values are checked by the robot that gets it.
        """

    @property
    def x_m(self) -> float:
        """Ahead of the robot's centre [m]."""

    @property
    def y_m(self) -> float:
        """Left of it [m]."""

    @property
    def yaw_rad(self) -> float:
        """Where its x axis points, counter-clockwise [rad]."""

    @property
    def robot_T_lidar(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(3,) the three together."""

    @property
    def height_m(self) -> float:
        """Above the floor [m]."""

    @property
    def upside_down(self) -> bool:
        """Its beams go round the other way than its scans say."""

    @property
    def sweep_s(self) -> float:
        """
        From the first beam to the last, where scans do not tell; negative: the last comes
        first [s].
        """

    @property
    def name(self) -> str:
        """For people."""

    def replace(self, **changes: Any) -> LidarMount:
        """The same with other values of some: ``lidar.replace(x_m=0.2)``."""

    def __eq__(self, other: object, /) -> bool: ...

    def __repr__(self) -> str: ...

class WheelModel:
    """A differential drive, of :attr:`Robot.wheels`; can't be changed."""

    @property
    def metres_per_count(self) -> float:
        """How far a wheel rolls for each encoder count."""

    @property
    def track_width_m(self) -> float:
        """Effective distance of the left from the right wheels, for turning."""

    @property
    def counts_are_cumulative(self) -> bool:
        """Since the start; else since the last reading."""

    @property
    def counter_bits(self) -> int:
        """Cumulative counters wrap at 2 to this power."""

    @property
    def radius_m(self) -> float:
        """Of wheels that are told as angles."""

    def __repr__(self) -> str: ...

class Robot:
    """
    What is fixed about a robot: wheels, and where its sensors sit. The defaults are those of
    the UCSD robot, ``robots/ucsd.toml``; a log's own words beat them. Can't be changed;
    replace() makes another one.
    """

    def __init__(self, toml: str = '') -> None:
        """
        From the text of a robot file. Raises OptionsError with all that is wrong with it.
        """

    @staticmethod
    def read(path: str | os.PathLike[str]) -> Robot:
        """From a robot file. Raises OptionsError, DataError."""

    def to_toml(self) -> str:
        """As the text of a robot file, with help texts."""

    @property
    def name(self) -> str:
        """What its file calls it."""

    @property
    def footprint_radius_m(self) -> float:
        """Cells this near to its path are free."""

    @property
    def odometry_scale(self) -> float:
        """Odometry's way / the real one; 1: learned while driving."""

    @property
    def wheels(self) -> WheelModel:
        """What its counts mean."""

    @property
    def lidars(self) -> list[LidarMount]:
        """Where each sits; a copy: replace() changes it."""

    @property
    def robot_T_lidars(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """(L, 3) x, y [m], yaw [rad] of each lidar on the robot."""

    def replace(self, changes: Mapping[str, Any] | None = None, /, *, lidars: Sequence[LidarMount] | None = None, **values: Any) -> Robot:
        """
        The same robot with other values of some keys of a robot file, two underscores for
        the dot: ``robot.replace(wheels__track_width_m=0.4, footprint_radius_m=0.3)``.

        :param changes: the same by their dotted keys: ``{"lidars[0].x_m": 0.2}``
        :param lidars: in place of all that it has
        :raises OptionsError: with all that is wrong with them
        """

    def __repr__(self) -> str: ...

def replaced_robot(robot: Robot, changes: Sequence[tuple[str, str]], lidars: Sequence[LidarMount] | None) -> Robot: ...

class LaserScan:
    """
    One sweep of a planar laser scanner; it can't be changed.

    Beam i points to ``angle_min_rad + i * angle_increment_rad``, counter-clockwise from the
    lidar's x axis. A finite range within the limits is a return, +inf means nothing within
    range, NaN a bad beam (REP-117).
    """

    def __init__(self, stamp_ns: int, ranges_m: numpy.typing.ArrayLike, *, angle_min_rad: float, angle_increment_rad: float, range_min_m: float = 0.0, range_max_m: float, time_increment_s: float = 0.0, lidar: int = 0, robot_T_lidar: numpy.typing.ArrayLike | None = None, intensities: numpy.typing.ArrayLike | None = None) -> None:
        """
        A scan of numbers that are copied. Raises ValueError for what is no scan.

        :param ranges_m: (N,) metres, which are kept as float32
        """

    @property
    def stamp_ns(self) -> int:
        """Nanoseconds of the recording's clock, exact."""

    @property
    def stamp_s(self) -> float:
        """The same in seconds, which a float holds to some 0.2 us."""

    @property
    def angle_min_rad(self) -> float:
        """Of beam 0 [rad]."""

    @property
    def angle_increment_rad(self) -> float:
        """From beam to beam [rad]; negative for clockwise scanners."""

    @property
    def range_min_m(self) -> float:
        """Nearer returns do not count [m]."""

    @property
    def range_max_m(self) -> float:
        """Nor do farther ones [m]."""

    @property
    def time_increment_s(self) -> float:
        """Between neighbouring beams [s]; 0: unknown, or all at once."""

    @property
    def lidar(self) -> int:
        """Which of the robot's lidars."""

    @property
    def robot_T_lidar(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))] | None:
        """(3,) x, y, yaw of the lidar on the robot, where the log states it."""

    @property
    def ranges_m(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None,), writable=False)]:
        """(N,) float32 [m]: a read-only view, no copy."""

    @property
    def intensities(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None,), writable=False)]:
        """
        (N,) float32 in the scanner's unit, a read-only view; (0,) when there are none.
        """

    @property
    def angles_rad(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(N,) float64: where each beam points, lidar frame [rad]."""

    def points(self, *, robot: Robot | None = None, velocity: numpy.typing.ArrayLike | None = None) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """
        (M, 2) returns in the robot's frame [m], in the order of the beams.

        :param robot: where the lidar sits, unless the scan itself says so
        :param velocity: (3,) of the robot in its own frame [m/s, m/s, rad/s]; undoes the
            motion during the sweep
        """

    def __len__(self) -> int: ...

    def __repr__(self) -> str: ...

class OdometryPose:
    """A pose that the robot's own dead reckoning reported."""

    def __init__(self, stamp_ns: int, odom_T_robot: numpy.typing.ArrayLike) -> None:
        """Of (3,) x, y [m], yaw [rad]. Raises ValueError."""

    @property
    def stamp_ns(self) -> int:
        """Nanoseconds of the recording's clock, exact."""

    @property
    def stamp_s(self) -> float:
        """The same in seconds, which a float holds to some 0.2 us."""

    @property
    def odom_T_robot(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(3,) x, y [m], yaw [rad] in the odometry's frame."""

class WheelTicks:
    """Encoder counts of the wheels."""

    def __init__(self, stamp_ns: int, counts: Sequence[int]) -> None:
        """Of four whole numbers, in the order of ``counts``."""

    @property
    def stamp_ns(self) -> int:
        """Nanoseconds of the recording's clock, exact."""

    @property
    def stamp_s(self) -> float:
        """The same in seconds, which a float holds to some 0.2 us."""

    @property
    def counts(self) -> tuple[int, int, int, int]:
        """
        (front right, front left, rear right, rear left), since the reading before or absolute, as the robot says.
        """

class ImuSample:
    """A reading of an inertial unit, on the axes of the robot."""

    def __init__(self, stamp_ns: int, angular_velocity_rad_s: numpy.typing.ArrayLike, linear_acceleration_m_s2: numpy.typing.ArrayLike) -> None:
        """Of (3,) rad/s and (3,) m/s^2. Raises ValueError."""

    @property
    def stamp_ns(self) -> int:
        """Nanoseconds of the recording's clock, exact."""

    @property
    def stamp_s(self) -> float:
        """The same in seconds, which a float holds to some 0.2 us."""

    @property
    def angular_velocity_rad_s(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(3,) about the axes of the robot [rad/s]."""

    @property
    def linear_acceleration_m_s2(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(3,) along the axes of the robot [m/s^2]."""

class RgbdFrame:
    """Which pictures an RGB-D camera took, and where they are; no pixels."""

    @property
    def stamp_ns(self) -> int:
        """Nanoseconds of the recording's clock, exact."""

    @property
    def stamp_s(self) -> float:
        """The same in seconds, which a float holds to some 0.2 us."""

    @property
    def colour_stamp_ns(self) -> int:
        """Of the colour picture; the two need not be taken at once."""

    @property
    def colour_path(self) -> str:
        """A file, or the topic of a recording; empty: there is only depth."""

    @property
    def depth_path(self) -> str:
        """Likewise; empty: there is only colour."""

class LogSummary:
    """What is in a log, as ``loopstone info`` tells."""

    @property
    def format(self) -> str:
        """The name of its format, such as ``carmen``."""

    @property
    def scans(self) -> int:
        """Of all lasers."""

    @property
    def duration_s(self) -> float:
        """From the first message to the last [s]."""

    @property
    def first_stamp_ns(self) -> int | None:
        """None of a log without messages."""

    @property
    def last_stamp_ns(self) -> int | None:
        """Likewise."""

    @property
    def counts(self) -> dict[str, int]:
        """Records of each sensor: laser, odometry, wheels, imu, camera."""

    @property
    def records_skipped(self) -> int:
        """Broken, repeated or out of order."""

    @property
    def verdict(self) -> str:
        """In one line: whether a map can be made of it."""

    @property
    def findings(self) -> list[tuple[str, str]]:
        """
        (``note``, ``warning`` or ``error``; in words), worst first. An error means that no map
        can be made.
        """

    def to_dict(self, log: str = '') -> dict[str, Any]:
        """All of it, as ``loopstone info --json`` prints it."""

    def __str__(self) -> str: ...

    def __repr__(self) -> str: ...

class LogMessages:
    """An iterator over the messages of a log, in the order of time."""

    def __iter__(self) -> LogMessages: ...

    def __next__(self) -> LaserScan | OdometryPose | WheelTicks | ImuSample | RgbdFrame: ...

    @property
    def robot(self) -> Robot:
        """Mounts and wheels, as the log states them."""

    @property
    def bytes_read(self) -> tuple[int, int]:
        """(done, total) bytes of the file as stored."""

    @property
    def records_skipped(self) -> int:
        """So far: broken, repeated or out of order."""

    @property
    def notes(self) -> list[str]:
        """What a user should know, in words; complete after the last message."""

    @property
    def warnings(self) -> list[str]:
        """
        What makes a result worse than the log could give; complete after the last message.
        """

    @property
    def choices(self) -> list[str]:
        """What was chosen where the log left a choice, in words."""

class Log:
    """
    A log by its name, and how it is read; see :func:`loopstone.open_log`. Each iteration
    reads it from its beginning, in bounded memory.
    """

    def __init__(self, path: str | os.PathLike[str], robot: Robot | None = None, strict: bool = False, stamps: str = 'auto', intensities: bool = False, topics: Mapping[str, Sequence[str]] = {}, base_frame: str = '', echo: str = 'first', slice_m: tuple[float, float] | None = None) -> None:
        """As :func:`loopstone.open_log` takes them. Nothing is opened yet."""

    def __iter__(self) -> LogMessages:
        """Opens it. Raises DataError when there is nothing readable."""

    @property
    def path(self) -> str:
        """As it was given."""

    @property
    def has_robot(self) -> bool:
        """A robot was given, which beats what the log says of it."""

    def summary(self) -> LogSummary:
        """
        Reads it to its end and tells what is in it. Raises DataError, KeyboardInterrupt.
        """

    def save(self, path: str | os.PathLike[str], *, format: str | None = None, force: bool = False, progress: loopstone._progress.ProgressLike = False) -> Conversion:
        """Writes it in another format; see :func:`loopstone.convert`."""

    def __repr__(self) -> str: ...

class Conversion:
    """A log that was written in another format."""

    @property
    def path(self) -> str:
        """Where it is."""

    @property
    def format(self) -> str:
        """Its name, such as ``carmen``."""

    @property
    def scans(self) -> int:
        """That were read."""

    @property
    def odometry_poses(self) -> int:
        """Likewise."""

    @property
    def wheel_readings(self) -> int:
        """Likewise."""

    @property
    def inertial_readings(self) -> int:
        """Likewise."""

    @property
    def camera_frames(self) -> int:
        """Likewise."""

    @property
    def poses_by_dead_reckoning(self) -> int:
        """Made of wheel counts and gyro, for a format with poses and no counts."""

    @property
    def records_skipped(self) -> int:
        """Of the old log: broken, repeated or out of order."""

    @property
    def notes(self) -> list[str]:
        """
        What the new format could not carry, or carries in its own way, in words.
        """

    @property
    def robot(self) -> Robot:
        """
        By which the new log's wheel counts are to be read: no log says it itself.
        """

    def __repr__(self) -> str: ...

def convert(log: Log, path: str | os.PathLike[str], format: str | None, force: bool, progress: object | None) -> Conversion: ...

class CalibratedValue:
    """A value that a log tells."""

    @property
    def value(self) -> float:
        """Means nothing when it is not observable."""

    @property
    def sigma(self) -> float:
        """One standard deviation."""

    @property
    def given(self) -> float:
        """As the robot or the log has it."""

    @property
    def observable(self) -> bool:
        """The robot moved so that the log tells it."""

    def __repr__(self) -> str: ...

class WheelCalibration:
    """What wheel counts by themselves, without a gyro, tell."""

    @property
    def translation_scale(self) -> CalibratedValue:
        """The way by the wheels / the laser's."""

    @property
    def rotation_scale(self) -> CalibratedValue:
        """The turns by the wheels / the laser's."""

    @property
    def turn_per_m_rad(self) -> CalibratedValue:
        """They turn so far a metre while the robot does not."""

    @property
    def metres_per_count(self) -> float:
        """Put right, if it is certainly wrong; else as given."""

    @property
    def track_width_m(self) -> float:
        """Likewise."""

class CalibrationResult:
    """
    How a robot's sensors sit and count, by its own motion; see
    :func:`loopstone.calibrate`.
    """

    @property
    def lidar_x_m(self) -> CalibratedValue:
        """Of the laser on the robot: ahead [m]."""

    @property
    def lidar_y_m(self) -> CalibratedValue:
        """To the left [m]."""

    @property
    def lidar_yaw_rad(self) -> CalibratedValue:
        """Where it looks [rad]."""

    @property
    def translation_scale(self) -> CalibratedValue:
        """Odometry's way / the laser's."""

    @property
    def rotation_scale(self) -> CalibratedValue:
        """Odometry's turns / the laser's."""

    @property
    def turn_bias_rad_s(self) -> CalibratedValue:
        """Odometry turns so fast while the robot does not."""

    @property
    def turn_per_m_rad(self) -> CalibratedValue:
        """Odometry turns so far a metre while the robot does not."""

    @property
    def laser_delay_s(self) -> CalibratedValue:
        """Scans show the robot so long after their stamp, by odometry's clock."""

    @property
    def sweep_s(self) -> CalibratedValue:
        """From the first beam to the last, where scans do not tell."""

    @property
    def motions(self) -> int:
        """That were compared."""

    @property
    def lidar_covariance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """(3, 3) of the laser's x, y, yaw on the robot."""

    @property
    def mount_is_off(self) -> bool:
        """
        The laser sits elsewhere than was told: significant, and both halves of the log say so.
        """

    @property
    def mount_is_certain(self) -> bool:
        """So much so that a map is made with the mount put right."""

    @property
    def laser_is_mirrored(self) -> bool:
        """Its beams go round the other way: it hangs upside down."""

    @property
    def mirror_is_in_doubt(self) -> bool:
        """Or it is odometry that turns the other way; no gyro tells."""

    @property
    def sweep_is_off(self) -> bool:
        """The sweep must be told."""

    @property
    def wheels(self) -> WheelCalibration | None:
        """By the wheels alone; None of a log without counts."""

    @property
    def robot(self) -> Robot:
        """
        With what is certainly wrong put right, as ``loopstone calibrate -o`` writes it.
        """

    @property
    def robot_given(self) -> Robot:
        """As it was told; beams that are off put right."""

    @property
    def warnings(self) -> list[str]:
        """Of the log, in plain words."""

    def __repr__(self) -> str: ...

def calibrate_log(log: Log, options: OptionValues, start_s: float, duration_s: float, max_scans: int, threads: int, progress: object | None) -> CalibrationResult: ...

class Trajectory:
    """
    Poses of the robot, their stamps strictly increasing; can't be changed.
    """

    def __init__(self, stamps_ns: numpy.typing.ArrayLike, poses: numpy.typing.ArrayLike) -> None:
        """
        Copies (N,) nanoseconds and (N, 3) x, y [m], yaw [rad]. Raises ValueError for what is no
        trajectory.
        """

    @property
    def stamps_ns(self) -> Annotated[NDArray[numpy.int64], dict(shape=(None,), writable=False)]:
        """(N,) int64 [ns], a read-only view."""

    @property
    def t(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(N,) float64 [s]; holds some 0.2 us."""

    @property
    def poses(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, 3), writable=False)]:
        """(N, 3) x, y [m], yaw [rad] in (-pi, pi], a read-only view."""

    @property
    def path_length_m(self) -> float:
        """Sum of the distances from each position to the next."""

    def at(self, stamp_ns: int) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))] | None:
        """
        (3,) the pose at a stamp, along the arc between its neighbours; None outside.
        """

    def to_tum(self) -> str:
        """
        The text of a TUM file, ``t x y z qx qy qz qw`` a line, as the program writes it.
        """

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a TUM file, whole or not at all. Raises DataError."""

    def to_pandas(self) -> pandas.DataFrame:
        """
        Columns x_m, y_m, yaw_rad, indexed by stamp_ns. Needs loopstone[pandas].
        """

    def to_evo(self) -> Any:
        """An evo.core.trajectory.PoseTrajectory3D. Needs evo, which is GPL-3."""

    def __len__(self) -> int: ...

    def __repr__(self) -> str: ...

def read_trajectory(path: str | os.PathLike[str]) -> Trajectory:
    """
    Reads a TUM file; z, roll and pitch are dropped. Raises DataError with the line.
    """

class GridMap:
    """A map of cells in percent, as ROS has it; can't be changed."""

    def __init__(self, cells: numpy.typing.ArrayLike, resolution_m: float, origin: numpy.typing.ArrayLike) -> None:
        """
        Copies (rows, columns) int8; row 0 has the lowest y. Raises ValueError.
        """

    @property
    def cells(self) -> Annotated[NDArray[numpy.int8], dict(shape=(None, None), writable=False)]:
        """(rows, columns) int8, a read-only view: percent occupied, -1 unknown."""

    @property
    def resolution_m(self) -> float:
        """Side of a cell."""

    @property
    def origin(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(2,) lower left corner of cell [0, 0] [m], map frame."""

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns): row grows with y, column with x."""

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """
        (left, right, bottom, top) [m], as ``imshow(cells, origin='lower', extent=...)`` takes it.
        """

    def save(self, path: str | os.PathLike[str]) -> None:
        """
        Writes NAME.yaml and NAME.pgm, as ROS map_server reads them: both or none.
        """

    def to_png(self) -> bytes:
        """The bytes of a PNG picture: white free, black occupied, grey unknown."""

    def plot(self, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
        """Draws it, metres on the axes. Needs loopstone[plot]."""

    def __repr__(self) -> str: ...

def read_map(path: str | os.PathLike[str]) -> GridMap:
    """
    Reads a map as ROS map_server does: YAML beside PGM or PNG. Raises DataError.
    """

class OccupancyMap:
    """An occupancy map that was made of scans; can't be changed."""

    @property
    def log_odds(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None, None), writable=False)]:
        """
        (rows, columns) float32, a read-only view: positive occupied, negative free, 0 even.
        """

    @property
    def observed(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None, None), writable=False)]:
        """(rows, columns) bool, a read-only view: a beam or the robot was there."""

    @property
    def probability(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None, None))]:
        """(rows, columns) float32 in [0, 1], computed; 0.5 where unknown."""

    @property
    def resolution_m(self) -> float:
        """Side of a cell."""

    @property
    def origin(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(2,) lower left corner of cell [0, 0] [m], map frame."""

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns): row grows with y, column with x."""

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """
        (left, right, bottom, top) [m], as ``imshow(cells, origin='lower', extent=...)`` takes it.
        """

    def to_grid(self) -> GridMap:
        """As cells of 0, 100 and -1: free, occupied, unknown."""

    def plot(self, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
        """Draws it, metres on the axes. Needs loopstone[plot]."""

    def __repr__(self) -> str: ...

class FloorTexture:
    """The colour of the floor, as an RGB-D camera saw it."""

    @property
    def colours(self) -> Annotated[NDArray[numpy.uint8], dict(shape=(None, None, None))]:
        """(rows, columns, 3) uint8, sRGB; black where unknown."""

    @property
    def coverage(self) -> Annotated[NDArray[numpy.uint8], dict(shape=(None, None))]:
        """(rows, columns) uint8: 255 seen, 128 filled in between, 0 unknown."""

    @property
    def resolution_m(self) -> float:
        """Side of a cell."""

    @property
    def origin(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(2,) lower left corner of cell [0, 0] [m], map frame."""

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns): row grows with y, column with x."""

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """
        (left, right, bottom, top) [m], as ``imshow(cells, origin='lower', extent=...)`` takes it.
        """

    @property
    def seen_area_m2(self) -> float:
        """Of the cells that were seen [m^2]."""

    @property
    def frames_used(self) -> int:
        """Pairs of colour and depth that gave colour."""

    @property
    def warnings(self) -> list[str]:
        """In plain words."""

class Landmark:
    """A reflector or beacon whose place is known; can't be changed."""

    def __init__(self, id: int, x_m: float, y_m: float, *, sigma_m: float = 0.0, radius_m: float = 0.0) -> None:
        """Values are checked by what it is given to."""

    @property
    def id(self) -> int:
        """No other landmark's."""

    @property
    def position(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(2,) x, y of its centre on the map [m]."""

    @property
    def sigma_m(self) -> float:
        """Standard deviation of x and of y."""

    @property
    def radius_m(self) -> float:
        """Of a round one, whose surface a laser meets; 0: it is flat."""

    def __repr__(self) -> str: ...

class FoundLandmark:
    """A landmark whose place a drive found."""

    @property
    def id(self) -> int:
        """1, 2, ... as they were first seen."""

    @property
    def position(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(2,) x, y of its centre on the map [m]."""

    @property
    def covariance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """(2, 2) of its position against the first pose, axes of the map [m^2]."""

    @property
    def sigma_m(self) -> float:
        """Among the other landmarks, without what moves all of them together."""

    @property
    def radius_m(self) -> float:
        """0: it is flat, or was seen from one side only."""

    @property
    def sightings(self) -> int:
        """That agree with it."""

    @property
    def visits(self) -> int:
        """How often it came into view."""

    def __repr__(self) -> str: ...

def read_landmarks(path: str | os.PathLike[str]) -> list[Landmark]:
    """
    Reads landmarks: CSV with ``id,x_m,y_m``, a folder that holds landmarks.csv, or UTIAS
    MRCLAM's. Raises DataError.
    """

def mapped_landmarks(found: Sequence[FoundLandmark]) -> list[Landmark]: ...

class PoseGraph:
    """
    Poses to estimate and measurements between them; can't be changed.

    The error of an edge is g2o's, e = vector(measurement^-1 * (pose_i^-1 * pose_j)). Held
    poses stay; without any, the first pose does.
    """

    def __init__(self, poses: numpy.typing.ArrayLike, edges: numpy.typing.ArrayLike, measurements: numpy.typing.ArrayLike, information: numpy.typing.ArrayLike, *, kinds: Sequence[str] | None = None, fixed: Sequence[int] = []) -> None:
        """
        Copies (N, 3) poses x, y [m], yaw [rad]; (E, 2) int64 nodes i, j from 0; (E, 3) pose j in
        the frame of i as measured; (E, 3, 3) or one (3, 3) information of x, y, yaw.

        :param kinds: ``odometry``, ``match`` or ``loop_closure`` of each edge; without, edges
            from i to i + 1 are odometry and all others loop closures, which robust kernels doubt
        :param fixed: nodes that stay where they are
        :raises ValueError: for arrays of other shapes
        :raises UsageError: naming the edge that makes no sense
        """

    @property
    def poses(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, 3), writable=False)]:
        """(N, 3) x, y [m], yaw [rad], a read-only view."""

    @property
    def edges(self) -> Annotated[NDArray[numpy.int64], dict(shape=(None, None))]:
        """(E, 2) int64 nodes."""

    @property
    def measurements(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """(E, 3) pose j in the frame of i."""

    @property
    def information(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None, None))]:
        """(E, 3, 3) of x, y, yaw."""

    @property
    def kinds(self) -> list[str]:
        """``odometry``, ``match`` or ``loop_closure`` of each edge."""

    @property
    def landmarks(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """(L, 2) [m]."""

    @property
    def fixed(self) -> list[int]:
        """Held nodes."""

    @property
    def cost(self) -> float:
        """Sum of e^T information e (no 1/2) at the poses."""

    @property
    def notes(self) -> list[str]:
        """What was guessed when it was read, in words."""

    def to_g2o(self) -> str:
        """The text of a g2o file; nodes by their numbers."""

    def save(self, path: str | os.PathLike[str]) -> None:
        """
        Writes a g2o file, whole or not at all; nodes have the names they were read with.
        """

    def to_networkx(self) -> networkx.MultiDiGraph[int]:
        """
        Nodes with ``pose``, edges with ``measurement``, ``information``, ``kind``. Needs loopstone[networkx].
        """

    def to_gtsam(self) -> tuple[Any, Any]:
        """
        (NonlinearFactorGraph, Values): BetweenFactorPose2, the first pose or held ones by a tight prior. Needs loopstone[gtsam].
        """

    def __repr__(self) -> str: ...

def read_graph(path: str | os.PathLike[str], information_order: str = 'guess') -> PoseGraph:
    """Reads a pose graph of g2o or TORO. Raises DataError with the line."""

class Certificate:
    """
    Whether the isotropic objective of SE-Sync is at its global minimum, with the proof.
    """

    @property
    def certified(self) -> bool:
        """It is proven, of the edges that it is about; also what bool() tells."""

    @property
    def status(self) -> str:
        """
        ``certified``, ``not_optimal``, ``gap_open``, ``not_converged``, ``numerical_failure`` or ``unsupported``.
        """

    @property
    def cost(self) -> float:
        """Of that objective at the poses."""

    @property
    def lower_bound(self) -> float:
        """No solution costs less; -inf when nothing is known."""

    @property
    def optimality_gap(self) -> float:
        """cost - lower_bound"""

    @property
    def min_eigenvalue(self) -> float:
        """Of the dual certificate matrix; at an optimum 0 to rounding."""

    @property
    def edges(self) -> int:
        """That it is about."""

    @property
    def edges_set_aside(self) -> int:
        """
        Edges that a robust kernel turned down before (weight below 0.5). Nothing is
        proven of them, nor that turning them down was right.
        """

    @property
    def loop_closures_set_aside(self) -> int:
        """
        Of these, loop closures. When it is most of them, what was proven is little
        more than that odometry agrees with itself.
        """

    @property
    def whole_graph(self) -> bool:
        """
        It is about every edge; also what a certificate should be asked that is
        to stand for a map.
        """

    def __bool__(self) -> bool: ...

    def __repr__(self) -> str: ...

class OptimizeResult:
    """A solved pose graph; see :func:`loopstone.optimize`."""

    @property
    def graph(self) -> PoseGraph:
        """At the solution."""

    @property
    def poses(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """(N, 3) x, y [m], yaw [rad]."""

    @property
    def status(self) -> str:
        """
        ``converged``, ``not_converged``, ``numerical_failure`` or ``disconnected``.
        """

    @property
    def converged(self) -> bool:
        """Whether that is the status."""

    @property
    def cost_initial(self) -> float:
        """Sum of e^T information e at the start, no kernel in it."""

    @property
    def cost(self) -> float:
        """The same at the solution."""

    @property
    def initial(self) -> str:
        """
        Where it began: ``file``, ``odometry``, ``spanning_tree`` or ``chordal``.
        """

    @property
    def iterations(self) -> int:
        """Of all solutions together, those of the certificate included."""

    @property
    def wall_time_s(self) -> float:
        """What it took [s]."""

    @property
    def edge_weights(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(E,) in [0, 1], by the robust kernel; 1 without."""

    @property
    def certificate(self) -> Certificate | None:
        """When it was asked for; of the edges that were kept."""

    def __repr__(self) -> str: ...

def optimize(graph: PoseGraph, initial: str, gnc: bool, certify: bool, options: OptionValues) -> OptimizeResult: ...

class LoopClosure:
    """A place that was recognised, or looked like it, with the evidence."""

    @property
    def from_node(self) -> int:
        """Of the graph; while the robot drives, the number of the submap."""

    @property
    def to_node(self) -> int:
        """Likewise."""

    @property
    def from_submap(self) -> int:
        """The older one."""

    @property
    def to_submap(self) -> int:
        """The newer one."""

    @property
    def from_T_to(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(3,) x, y [m], yaw [rad], as measured by registration."""

    @property
    def covariance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """(3, 3) of from_T_to [m^2, m rad, rad^2]."""

    @property
    def score(self) -> float:
        """[0, 1], share of points explained."""

    @property
    def overlap(self) -> float:
        """[0, 1], share of points that fall where the older submap was observed."""

    @property
    def agreement(self) -> float:
        """
        [0, 1], of those, share on a surface that faces the same way; or, where that is more, of each submap's surfaces that the other one could see, share that it saw.
        """

    @property
    def chi2(self) -> float | None:
        """
        Disagreement with the graph's poses; None of what was never in the graph.
        """

    @property
    def stands(self) -> bool:
        """It is an edge of the graph."""

    @property
    def state(self) -> str:
        """``waiting``, ``standing``, ``rejected`` or ``revoked``."""

    @property
    def reason(self) -> str:
        """Why it does not stand, in words; empty when it does."""

    def __repr__(self) -> str: ...

class QualityMeasure:
    """One figure and what it means."""

    @property
    def name(self) -> str:
        """With its unit at the end, as in summary.json."""

    @property
    def title(self) -> str:
        """In words."""

    @property
    def value(self) -> float:
        """In the unit of its name; of an unknown one it means nothing."""

    @property
    def verdict(self) -> str:
        """``unknown``, ``good``, ``doubtful`` or ``bad``."""

    @property
    def sentence(self) -> str:
        """What it means for the map."""

    def __repr__(self) -> str: ...

class MapVerdict:
    """How good a map is, as far as its own scans can tell."""

    @property
    def overall(self) -> str:
        """
        ``unknown``, ``good``, ``doubtful`` or ``bad``: the worst of what is known.
        """

    @property
    def sentence(self) -> str:
        """What that means, in words."""

    @property
    def measures(self) -> list[QualityMeasure]:
        """Always the same ones, in the same order."""

    def __str__(self) -> str: ...

    def __repr__(self) -> str: ...

class MapResult:
    """What the mapper made of a log."""

    @property
    def trajectory(self) -> Trajectory:
        """map_T_robot at every scan."""

    @property
    def odometry(self) -> Trajectory:
        """odom_T_robot at every scan, by dead reckoning alone."""

    @property
    def covariances(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, 3, 3), writable=False)] | None:
        """
        (N, 3, 3) of each pose of the trajectory against the first, axes of the map
        [m^2, m rad, rad^2], a read-only view; None when a pose is held by nothing.
        Worked out when first asked for, up to a millisecond a pose.
        """

    @property
    def graph(self) -> PoseGraph:
        """The pose graph of all key scans, at its final poses."""

    @property
    def node_stamps_ns(self) -> Annotated[NDArray[numpy.int64], dict(shape=(None,))]:
        """(K,) int64 [ns] of the graph's poses."""

    @property
    def map(self) -> OccupancyMap | None:
        """The occupancy map; None when it would be too large: see ``warnings``."""

    @property
    def texture(self) -> FloorTexture | None:
        """The floor in colour, when the log has RGB-D."""

    @property
    def landmarks(self) -> list[FoundLandmark]:
        """
        The reflectors that were found, of a map with ``landmarks=True``; in the order of the
        graph's landmarks.
        """

    @property
    def loop_closures(self) -> list[LoopClosure]:
        """All that were found, those that do not stand included."""

    @property
    def verdict(self) -> MapVerdict:
        """How good the map is, in words, with the figures behind them."""

    @property
    def possible_error_m(self) -> float:
        """How far a part of the map may be off, by all that hangs loosely."""

    @property
    def possible_error_rad(self) -> float:
        """By how much it may be turned."""

    @property
    def summary(self) -> dict[str, Any]:
        """Every figure of the run, units in the names: what summary.json has."""

    @property
    def warnings(self) -> list[str]:
        """In plain words."""

    @property
    def complete(self) -> bool:
        """False when the run was interrupted."""

    @property
    def failure(self) -> str:
        """
        What was asked for and can't be had, the floor's colour or landmarks, and why; empty when
        all is there.
        """

    @property
    def robot(self) -> Robot:
        """That the map was made with: mounts and wheels."""

    @property
    def has_state(self) -> bool:
        """
        Another drive can go on with it, and it can be edited: made with ``keep_state=True``.
        """

    @property
    def drives(self) -> int:
        """How many drives it is of: more than 1 of a map that was gone on with."""

    @property
    def options_toml(self) -> str:
        """The effective options."""

    def save(self, folder: str | os.PathLike[str], *, force: bool = False) -> None:
        """
        Writes the files that ``loopstone map`` writes, all of them or none. Raises UsageError
        when the folder holds something, unless forced.
        """

    def to_png(self) -> bytes:
        """The bytes of map.png: map, path, closures, scale bar."""

    def plot(self, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
        """
        Draws map, path and closures, metres on the axes. Needs loopstone[plot].
        """

    def __repr__(self) -> str: ...

def map_log(log: Log, options: OptionValues, start_s: float, duration_s: float, max_scans: int, threads: int, texture: bool, landmarks: bool, keep_state: bool, from_folder: str | os.PathLike[str] | None, from_result: MapResult | None, progress: object | None) -> MapResult: ...

def map_messages(messages: Iterable[object], robot: Robot | None, options: OptionValues, landmarks: bool, threads: int, progress: object | None) -> MapResult: ...

class EditReport:
    """What became of an edit."""

    @property
    def applied(self) -> bool:
        """False: it was refused, and nothing has changed."""

    @property
    def told(self) -> str:
        """What it did, or why it was refused, in words."""

    @property
    def closure(self) -> LoopClosure | None:
        """Added, taken out or refused; else None."""

    @property
    def closures_revoked(self) -> int:
        """Others that contradict the graph since."""

    @property
    def moved_m(self) -> float:
        """How far a key scan moved at most."""

    @property
    def moved_rad(self) -> float:
        """How far one turned at most."""

    @property
    def verdict_before(self) -> str:
        """Of the graph alone."""

    @property
    def verdict(self) -> str:
        """Of the graph since."""

    def __bool__(self) -> bool: ...

    def __repr__(self) -> str: ...

class MapEditor:
    """
    A finished map in somebody's hand, as ``loopstone edit`` has it: a list of edits, done to
    what the map was made of. Points and polygons are told in the frame of the map before all
    edits.
    """

    def __init__(self, map: MapResult | str | os.PathLike[str], *, threads: int = 0) -> None:
        """
        Of a map made with ``keep_state=True``, or of the folder that it was saved in, as
        ``loopstone edit`` takes it: if that was edited, with these edits first. Map and folder stay
        as they are. Raises UsageError, DataError.
        """

    def add(self, kind: str, **keys: Any) -> EditReport:
        """
        One more edit: ``editor.add("crop", box=[0, 0, 20, 10])``. Kinds and keys are
        those of docs/editing.md. One that is refused is on the list all the same, and changes
        nothing. Raises OptionsError for what is no edit.
        """

    def add_toml(self, toml: str, name: str = 'edits') -> list[EditReport]:
        """All ``[[edit]]`` tables of a text, in their order."""

    def undo(self) -> bool:
        """Takes the last one away; False when there is none."""

    def __len__(self) -> int: ...

    @property
    def reports(self) -> list[EditReport]:
        """What became of each."""

    def to_toml(self) -> str:
        """The list, as ``loopstone edit --edits`` takes it."""

    @property
    def map_T_keys(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """
        (K, 3) of the graph's nodes with all edits so far, in the frame that they ask for.
        """

    @property
    def verdict(self) -> str:
        """Of the graph with all edits so far, before the map is drawn."""

    @property
    def loop_closures(self) -> list[LoopClosure]:
        """With all edits so far."""

    def draw(self, progress: Callable[[str, int, int, int, float], object] | None = None) -> MapResult:
        """
        The map with the edits, with all that map() gives but the floor's colour; its save()
        writes the edits and the masks of zones, too. Raises UsageError while one is refused.
        """

    def __repr__(self) -> str: ...

def add_edit(editor: MapEditor, toml: str) -> EditReport: ...

class SiteSession:
    """One drive of a robot in the building, and what became of it."""

    @property
    def id(self) -> int:
        """By which the site knows it."""

    @property
    def log(self) -> str:
        """Where its log was."""

    @property
    def digest(self) -> str:
        """Checksum of its messages: no two sessions of a site have the same."""

    @property
    def begins(self) -> datetime.datetime:
        """
        When it was driven, UTC, by the log's stamps or as ``add`` was told; sessions are joined
        in this order.
        """

    @property
    def begins_ns(self) -> int:
        """The same in nanoseconds since 1970, exact."""

    @property
    def added(self) -> datetime.datetime:
        """When it came into the site, UTC."""

    @property
    def robot(self) -> Robot:
        """That drove: mounts and wheels, as its own map was made with."""

    @property
    def scans(self) -> int:
        """How many it has."""

    @property
    def path_m(self) -> float:
        """How far it drove [m]."""

    @property
    def duration_s(self) -> float:
        """How long [s]."""

    @property
    def status(self) -> str:
        """``joined``, ``pending``, ``refused``, ``retired`` or ``excluded``."""

    @property
    def reason(self) -> str:
        """Why it is not joined; empty when it is."""

    @property
    def closures(self) -> int:
        """That stand and tie it to others."""

    @property
    def verdict(self) -> str:
        """On its own map: ``unknown``, ``good``, ``doubtful`` or ``bad``."""

    @property
    def sentence(self) -> str:
        """What that means, in words."""

    def __repr__(self) -> str: ...

class SiteEvent:
    """Something that was done to a site."""

    @property
    def at(self) -> datetime.datetime:
        """When, UTC."""

    @property
    def what(self) -> str:
        """``add``, ``remove``, ``rebuild``, ``edit``, ``exclude`` or ``undo``."""

    @property
    def log(self) -> str:
        """The session's log; empty: of the site as a whole."""

    @property
    def text(self) -> str:
        """What came of it, in words."""

    def __repr__(self) -> str: ...

class SiteEdit:
    """Something that was corrected in a site by hand."""

    @property
    def id(self) -> int:
        """By which it is undone."""

    @property
    def at(self) -> datetime.datetime:
        """When it was done, UTC."""

    @property
    def kind(self) -> str:
        """``exclude``, ``free``, ``wall`` or ``unknown``."""

    @property
    def session(self) -> int | None:
        """The id of the session that is left out; None: it is a polygon."""

    @property
    def polygon(self) -> numpy.typing.NDArray[numpy.float64] | None:
        """
        (N, 2) its corners [m], map frame; None: a session is left out, or what it lay on is no
        part of the map.
        """

    def __repr__(self) -> str: ...

class SiteTie:
    """What was found between two sessions of a site."""

    @property
    def older(self) -> int:
        """The id of a session."""

    @property
    def newer(self) -> int:
        """The id of a later one."""

    @property
    def closures(self) -> list[LoopClosure]:
        """
        Places that were recognised, or looked like it; those that do not stand included. Submaps
        and nodes are counted within their sessions, ``from`` is of the older one.
        """

    def __repr__(self) -> str: ...

class MapChange:
    """A place where a building differs from what it was."""

    @property
    def appeared(self) -> bool:
        """Something stands there now; False: it is gone."""

    @property
    def low(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(2,) lowest x, y of the box around it [m], map frame."""

    @property
    def high(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(2,) highest x, y of that box."""

    @property
    def area_m2(self) -> float:
        """Of its cells alone."""

    def __repr__(self) -> str: ...

class SiteMap(MapResult):
    """
    The map of a site: what the last visits agree on, with all that a MapResult of one drive has.
    Scans of the trajectory follow one another, session by session.
    """

    @property
    def sessions(self) -> list[SiteSession]:
        """
        That are joined, in the order in which they were driven; later ones than the map's date
        hold it together, too, and are not drawn on it.
        """

    @property
    def trajectories(self) -> list[Trajectory]:
        """map_T_robot of each session, by the stamps of its own log."""

    @property
    def movable(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None, None), writable=False)]:
        """
        (rows, columns) float32 in [0, 1], a read-only view, of the cells of ``map``: on what share
        of visits something stands there, where they are not of one mind: doors, chairs, what is
        moved; 0 elsewhere.
        """

    @property
    def has_scans(self) -> bool:
        """
        A floor plan is drawn through what the lasers measured: made with ``keep_scans=True``.
        """

    def save(self, folder: str | os.PathLike[str], *, force: bool = False) -> None:
        """
        Writes the files that ``loopstone site map`` writes. Raises UsageError when the folder
        holds something, unless forced.
        """

    @property
    def edits(self) -> list[SiteEdit]:
        """What it was corrected by: all edits of the site."""

    def record(self, path: str | os.PathLike[str]) -> None:
        """
        Writes map, paths, closures and poses as MCAP for Foxglove, Lichtblick and RViz, as
        ``loopstone site map --mcap`` does. A file that is there is replaced.
        """

    def __repr__(self) -> str: ...

class SiteChanges:
    """
    What appeared in a building and what is gone, as a sequence of MapChange, largest first.
    """

    @property
    def boxes(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """
        (C, 4) lowest x, lowest y, highest x, highest y of each [m], map frame.
        """

    @property
    def areas_m2(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(C,) of the cells of each."""

    def __len__(self) -> int: ...

    def __getitem__(self, index: int) -> MapChange: ...

    def __iter__(self) -> Iterator[MapChange]: ...

    @property
    def now(self) -> SiteMap:
        """The map of the later date, in whose frame the changes are."""

    @property
    def before(self) -> OccupancyMap:
        """What the building was before."""

    def save(self, folder: str | os.PathLike[str], *, force: bool = False) -> None:
        """
        Writes changes.png and changes.csv, as ``loopstone site changes`` does. Raises
        UsageError when the folder holds something, unless forced.
        """

    def __repr__(self) -> str: ...

def site_map(path: str | os.PathLike[str], until_ns: int | None, keep_scans: bool, threads: int, progress: object | None) -> SiteMap: ...

def site_changes(path: str | os.PathLike[str], from_ns: int, to_ns: int | None, threads: int, progress: object | None) -> SiteChanges: ...

def site_cells(path: str | os.PathLike[str], threads: int) -> GridMap: ...

def is_site(path: str | os.PathLike[str]) -> bool: ...

def site_sessions(path: str | os.PathLike[str]) -> list[SiteSession]: ...

def site_events(path: str | os.PathLike[str]) -> list[SiteEvent]: ...

def site_edits(path: str | os.PathLike[str]) -> list[SiteEdit]: ...

def site_ties(path: str | os.PathLike[str]) -> list[SiteTie]: ...

def site_problems(path: str | os.PathLike[str]) -> list[str]: ...

def site_options_toml(path: str | os.PathLike[str]) -> str: ...

def site_bytes(path: str | os.PathLike[str]) -> int: ...

def parse_utc(text: str, until: bool) -> int | None: ...

def exclude_from_site(path: str | os.PathLike[str], id: int, threads: int, progress: object | None) -> list[SiteEdit]: ...

def include_in_site(path: str | os.PathLike[str], id: int, threads: int, progress: object | None) -> list[SiteEdit]: ...

def undo_in_site(path: str | os.PathLike[str], id: int, threads: int, progress: object | None) -> list[SiteEdit]: ...

def set_cells_of_site(path: str | os.PathLike[str], kind: str, corners: Sequence[tuple[float, float]], threads: int, progress: object | None) -> list[SiteEdit]: ...

def open_site(path: str | os.PathLike[str], options: OptionValues | None, create: bool) -> None: ...

def add_to_site(path: str | os.PathLike[str], log: Log, name: str | os.PathLike[str], begins_ns: int | None, start_s: float, duration_s: float, max_scans: int, threads: int, progress: object | None) -> SiteSession: ...

def prune_site(path: str | os.PathLike[str], sessions: Sequence[int], pending: bool, threads: int, progress: object | None) -> tuple[int, int, int]: ...

def rebuild_site(path: str | os.PathLike[str], threads: int, progress: object | None) -> list[SiteSession]: ...

class PlanSegment:
    """
    A straight piece of surface as it is seen from one side: a wall that is seen from both has
    two. Who goes from its start to its end has free space on his left. Standard deviations are
    about the map, not about the world.
    """

    @property
    def start(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(2,) x, y [m]."""

    @property
    def end(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(2,) x, y [m]."""

    @property
    def normal(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(2,) of length 1, towards the free side."""

    @property
    def length_m(self) -> float:
        """From start to end."""

    @property
    def layer(self) -> str:
        """
        ``structure``: walls and pillars; ``hidden``: wall that furniture hides, drawn through;
        ``movable``: furniture and other things that stand about.
        """

    @property
    def sigma_across_m(self) -> float:
        """Standard deviation of the line, at its middle."""

    @property
    def sigma_yaw_rad(self) -> float:
        """Of its direction."""

    @property
    def sigma_start_m(self) -> float:
        """Of its start, along the line."""

    @property
    def sigma_end_m(self) -> float:
        """Of its end, along the line."""

    @property
    def squared(self) -> bool:
        """Its direction is that of an axis, from which it could not be told."""

    def __repr__(self) -> str: ...

class PlanRoom:
    """A piece of floor that walls and doors go round."""

    @property
    def polygon(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """
        (V, 2) its corners [m], counter-clockwise along the faces of its walls; the floor under
        furniture belongs to it.
        """

    @property
    def sides(self) -> list[str]:
        """
        What the outline runs along from each corner to the next: ``wall``, ``hidden``, ``door`` or
        ``open``, where nothing is known.
        """

    @property
    def holes(self) -> list[numpy.typing.NDArray[numpy.float64]]:
        """(V, 2) each, clockwise: walls and rooms that it goes round."""

    @property
    def area_m2(self) -> float:
        """Without its holes."""

    @property
    def area_sigma_m2(self) -> float:
        """Standard deviation of that."""

    @property
    def closed(self) -> bool:
        """There are walls and doors all around."""

    @property
    def perimeter_m(self) -> float:
        """Of the outline and of holes."""

    @property
    def open_m(self) -> float:
        """Of that, where no wall was seen."""

    @property
    def hidden_m(self) -> float:
        """Of that, where a wall was drawn through."""

    @property
    def doors(self) -> list[int]:
        """Its doors: places in the plan's ``doors``."""

    @property
    def label(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(2,) where its name stands best [m]: farthest from its walls."""

    def __repr__(self) -> str: ...

class PlanDoor:
    """An opening between two jambs: a door, or what is wider than one."""

    @property
    def kind(self) -> str:
        """``door``, or ``opening`` where it is wider than 1.4 m."""

    @property
    def start(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(2,) one of its jambs, in the middle of the wall [m]."""

    @property
    def end(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(2,) the other one."""

    @property
    def width_m(self) -> float:
        """Clear, between the jambs."""

    @property
    def width_sigma_m(self) -> float:
        """Standard deviation of that."""

    @property
    def depth_m(self) -> float:
        """Of the wall; 0: only one of its faces was seen."""

    @property
    def room(self) -> int | None:
        """
        Of which room it is a door: a place in the plan's ``rooms``; None: outside, or unexplored.
        """

    @property
    def other_room(self) -> int | None:
        """Likewise, on its other side."""

    def __repr__(self) -> str: ...

class PlanAxis:
    """A direction along which walls run, and at right angles to it."""

    @property
    def yaw_rad(self) -> float:
        """[-pi/4, pi/4), frame of the plan."""

    @property
    def sigma_rad(self) -> float:
        """Standard deviation of that."""

    @property
    def share(self) -> float:
        """Of the length of all segments, those that run along it."""

    def __repr__(self) -> str: ...

class FloorPlan:
    """
    A map as lines, rooms and doors; in the frame of the map unless it was straightened.
    """

    @property
    def segments(self) -> list[PlanSegment]:
        """All straight pieces of surface, of all layers."""

    @property
    def walls(self) -> list[PlanSegment]:
        """Those of the layer ``structure``."""

    @property
    def rooms(self) -> list[PlanRoom]:
        """Largest first."""

    @property
    def doors(self) -> list[PlanDoor]:
        """Doors and openings."""

    @property
    def axes(self) -> list[PlanAxis]:
        """Greatest share first; none: walls run anyhow."""

    def lines(self, layer: Literal['structure', 'hidden', 'movable'] | None = None) -> numpy.typing.NDArray[numpy.float64]:
        """(N, 2, 2) start and end of each segment [m], of one layer or of all."""

    def length_m(self, layer: Literal['structure', 'hidden', 'movable'] = 'structure') -> float:
        """Of all segments of a layer."""

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """(left, right, bottom, top) [m]."""

    @property
    def from_scans(self) -> bool:
        """
        Its lines go through what the laser measured; else through the cells of the map, which is
        coarser.
        """

    @property
    def plan_T_map(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(3,) x, y [m], yaw [rad]: 0 unless it was straightened."""

    def straightened(self) -> FloorPlan:
        """The same plan, turned so that most walls run along x and y."""

    def write_svg(self, path: str | os.PathLike[str], *, title: str | None = None, anchor: tuple[float, float, float] | None = None, force: bool = False) -> None:
        """
        A sheet of paper, A4 to A0, with areas and dimensions, as ``loopstone export`` writes it.
        ``title``: instead of the name of the map. ``anchor``: (latitude, longitude, bearing of the
        map's x axis clockwise from north) [deg]; there is an arrow to the north then. Raises
        UsageError where there is a file already, unless forced.
        """

    def write_pdf(self, path: str | os.PathLike[str], *, title: str | None = None, anchor: tuple[float, float, float] | None = None, force: bool = False) -> None:
        """
        A sheet of paper, A4 to A0, with areas and dimensions, as ``loopstone export`` writes it.
        ``title``: instead of the name of the map. ``anchor``: (latitude, longitude, bearing of the
        map's x axis clockwise from north) [deg]; there is an arrow to the north then. Raises
        UsageError where there is a file already, unless forced.
        """

    def write_dxf(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """
        For CAD: DXF release 12, metres, layers STRUCTURE, HIDDEN, MOVABLE, ROOMS, DOORS, AREAS.
        """

    def write_geojson(self, path: str | os.PathLike[str], anchor: tuple[float, float, float], *, force: bool = False) -> None:
        """
        On the earth: ``anchor`` is (latitude, longitude) of the map's origin and the bearing of
        its x axis, clockwise from true north [deg]. Straightened or not, it is the same.
        """

    def to_geojson(self, anchor: tuple[float, float, float]) -> dict[str, Any]:
        """What write_geojson() writes: a FeatureCollection."""

    def plot(self, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
        """
        Draws rooms, walls and doors, metres on the axes. Needs loopstone[plot].
        """

    def __repr__(self) -> str: ...

def read_floor_plan(path: str | os.PathLike[str], threads: int) -> FloorPlan: ...

def floor_plan_of_result(map: MapResult, threads: int) -> FloorPlan: ...

def floor_plan_of_site_map(map: SiteMap, threads: int) -> FloorPlan: ...

def floor_plan_of_cells(map: GridMap) -> FloorPlan: ...

class MapEvent:
    """What happened since the scan before."""

    @property
    def kind(self) -> str:
        """
        ``submap_opened``, ``submap_frozen``, ``submap_dropped``, ``closure``,
        ``graph_solved``, ``odometry_fault``, ``laser_fault`` or ``path_broken``.
        """

    @property
    def submap(self) -> int | None:
        """The submap's number, of events of submaps."""

    @property
    def closure(self) -> LoopClosure | None:
        """What was found, came to stand, or was revoked."""

    @property
    def largest_shift_m(self) -> float | None:
        """Of a solved graph: how far a submap moved."""

    def __repr__(self) -> str: ...

class MapUpdate:
    """
    Where the robot is at a scan. Frames as REP-105 has them: odom goes on smoothly and
    drifts; map is where closed loops put the robot, so map_T_odom moves when they close.
    """

    @property
    def stamp_ns(self) -> int:
        """Nanoseconds of the recording's clock, exact."""

    @property
    def stamp_s(self) -> float:
        """The same in seconds, which a float holds to some 0.2 us."""

    @property
    def scan(self) -> int:
        """Its number among all scans, from 0."""

    @property
    def odom_T_robot(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(3,) x, y [m], yaw [rad]."""

    @property
    def map_T_odom(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(3,) x, y [m], yaw [rad]: what corrects odometry."""

    @property
    def map_T_robot(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(3,) x, y [m], yaw [rad]: where the robot is on the map."""

    @property
    def covariance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """(3, 3) of map_T_robot against what is around it, axes of the map."""

    @property
    def status(self) -> str:
        """``tracked``, ``degenerate``, ``bridged`` or ``lost``."""

    @property
    def open_direction_rad(self) -> float | None:
        """The direction that the laser leaves open, when degenerate."""

    @property
    def key_scan(self) -> int | None:
        """Its number among the key scans, if it is one."""

    @property
    def events(self) -> list[MapEvent]:
        """What happened since the update before."""

    @property
    def missed(self) -> int:
        """Updates given up before this one."""

    def __repr__(self) -> str: ...

class Mapper:
    """
    Maps while the robot drives. Messages come as they are measured; the result is the same,
    to the byte, as that of :func:`loopstone.map` without a second pass for beams that are not
    as the log tells. Any thread may call it, one at a time works.
    """

    def __init__(self, robot: Robot | None = None, *, options: loopstone.options.MapOptions | Mapping[str, Any] | str | None = None, threads: int = 0, **overrides: Any) -> None:
        """As :func:`loopstone.map` takes its options. Raises OptionsError."""

    def add(self, message: LaserScan | OdometryPose | WheelTicks | ImuSample | RgbdFrame) -> list[MapUpdate]:
        """
        A message as it was measured. Returns the updates that it led to, one a scan: none
        while a scan waits for odometry of its time, at most 0.25 s; rarely several.
        """

    def begin_drive(self) -> None:
        """
        What comes next is of another drive in the same building, which may begin anywhere.
        """

    def live_map(self) -> OccupancyMap:
        """The occupancy map so far, all of one moment."""

    @property
    def key_poses(self) -> Trajectory:
        """map_T_robot of the key scans so far, where the graph has them now."""

    @property
    def loop_closures(self) -> list[LoopClosure]:
        """So far."""

    @property
    def scans(self) -> int:
        """So far."""

    def finish(self, progress: Callable[[str, int, int, int, float], object] | None = None) -> MapResult:
        """
        Last closures, last solution, the final map of all scans. Nothing may follow.
        """

class LocalizationEstimate:
    """Where the robot is at a scan, and how far to trust that."""

    @property
    def stamp_ns(self) -> int:
        """Nanoseconds of the recording's clock, exact."""

    @property
    def stamp_s(self) -> float:
        """The same in seconds, which a float holds to some 0.2 us."""

    @property
    def map_T_robot(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(3,) x, y [m], yaw [rad]."""

    @property
    def map_T_odom(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(3,) moves when the pose is corrected (REP-105)."""

    @property
    def odom_T_robot(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(3,) by odometry since the first scan: smooth, drifts."""

    @property
    def covariance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """(3, 3) of map_T_robot, axes of the map [m^2, m rad, rad^2]."""

    @property
    def state(self) -> str:
        """``TRACKING``, ``DOUBTFUL`` or ``LOST``."""

    @property
    def probability(self) -> float:
        """That the pose is within 0.2 m and 5 deg of the truth."""

    @property
    def refined(self) -> bool:
        """By registration to the map; else the particles' mean."""

    @property
    def hypotheses(self) -> int:
        """How many places the robot may be at."""

    @property
    def places(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """
        (H, 3) these places, the most probable first, as the particles have them;
        map_T_robot is the first one's, refined.
        """

    @property
    def place_probabilities(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(H,) share of the belief that each place has; they sum to 1."""

    @property
    def particles(self) -> int:
        """How many there are at the scan."""

    @property
    def travelled_m(self) -> float:
        """By odometry since the first scan [m]."""

    def __repr__(self) -> str: ...

class LocalizationResult:
    """Where a robot was on a known map."""

    @property
    def trajectory(self) -> Trajectory:
        """map_T_robot at every scan from the first pose on."""

    @property
    def estimates(self) -> list[LocalizationEstimate]:
        """One a scan, with all that is known of it."""

    @property
    def probability(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(N,) that each pose is within 0.2 m and 5 deg of the truth."""

    @property
    def covariances(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None, None))]:
        """(N, 3, 3) [m^2, m rad, rad^2]."""

    @property
    def warnings(self) -> list[str]:
        """In plain words."""

    @property
    def summary(self) -> dict[str, Any]:
        """What summary.json has."""

    def save(self, folder: str | os.PathLike[str], *, force: bool = False) -> None:
        """
        Writes the files of ``loopstone localize --report``, all of them or none.
        """

    def __repr__(self) -> str: ...

class LocalizationMap:
    """A map made ready for localisation, once; many may share it."""

    def __init__(self, map: GridMap) -> None:
        """Raises UsageError when the map shows no wall or nothing free."""

    @property
    def free_area_m2(self) -> float:
        """Where the robot may be [m^2]."""

class Localizer:
    """
    Follows a robot on a known map while it drives. Any thread may call it, one at a time works.
    """

    def __init__(self, map: LocalizationMap | GridMap | OccupancyMap | MapResult | str | os.PathLike[str], robot: Robot | None = None, *, initial: numpy.typing.ArrayLike | None = None, initial_sigma_m: float = 0.5, initial_sigma_rad: float = 0.26, seed: int = 1, options: loopstone.options.LocalizationOptions | Mapping[str, Any] | str | None = None, threads: int = 0, **overrides: Any) -> None:
        """
        As :func:`loopstone.localize` takes them. Raises OptionsError, UsageError.
        """

    def add(self, message: LaserScan | OdometryPose | WheelTicks | ImuSample | RgbdFrame) -> list[LocalizationEstimate]:
        """A message as it was measured. Returns the estimates that it led to."""

    def restart_at(self, pose: numpy.typing.ArrayLike, sigma_m: float = 0.5, sigma_rad: float = 0.26) -> None:
        """Somebody says where the robot is at the next scan."""

    @property
    def particles(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """(P, 3) what it believes at the newest scan."""

    def finish(self) -> LocalizationResult:
        """Ends the recording. Nothing may follow."""

def localize_log(log: Log, map: LocalizationMap, options: OptionValues, initial: numpy.typing.ArrayLike | None, initial_sigma_m: float, initial_sigma_rad: float, seed: int, calibration: bool, start_s: float, duration_s: float, max_scans: int, threads: int, progress: object | None) -> LocalizationResult: ...

def localize_by_landmarks(log: Log, landmarks: Sequence[Landmark], options: OptionValues, initial: numpy.typing.ArrayLike | None, initial_sigma_m: float, initial_sigma_rad: float, nameless: bool, start_s: float, duration_s: float, max_scans: int, progress: object | None) -> LocalizationResult: ...

class PlaceCandidate:
    """A pose that scans may have been taken from."""

    @property
    def map_T_robot(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(3,) x, y [m], yaw [rad]."""

    @property
    def covariance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """(3, 3) of map_T_robot, axes of the map [m^2, m rad, rad^2]."""

    @property
    def probability(self) -> float:
        """That the robot is within 0.2 m and 5 deg of the pose."""

    @property
    def explained(self) -> float:
        """
        [0, 1], of the returns where the map knows what is there, the share on a wall.
        """

    @property
    def violations(self) -> float:
        """[0, 1], share of the beams that went on behind a wall of the map."""

    @property
    def unexpected(self) -> float:
        """
        [0, 1], share of the beams that ended well before one: people, things that are new.
        """

    @property
    def known(self) -> float:
        """[0, 1], share of the returns where the map knows what is there."""

    @property
    def silent(self) -> float:
        """[0, 1], share of the beams without a return where a wall is near."""

    def __repr__(self) -> str: ...

class Relocalization:
    """
    Where on a map scans may have been taken; see
    :func:`loopstone.relocalize`.
    """

    @property
    def candidates(self) -> list[PlaceCandidate]:
        """The most probable first; may be none."""

    @property
    def poses(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """(C, 3) map_T_robot of the candidates."""

    @property
    def probabilities(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(C,) of the candidates."""

    @property
    def none_probability(self) -> float:
        """
        That the robot is at none of these places: elsewhere on the map, or not on it.
        """

    @property
    def complete(self) -> bool:
        """False: more places look alike than were looked into."""

    def __len__(self) -> int: ...

    def __repr__(self) -> str: ...

def relocalize(scans: Sequence[LaserScan], map: LocalizationMap, robot: Robot | None, odom_T_robot: numpy.typing.ArrayLike | None, velocity: numpy.typing.ArrayLike | None, threads: int) -> Relocalization: ...

class MatchResult:
    """Where a scan or cloud lies in the frame of another, or of a map."""

    @property
    def dimension(self) -> int:
        """2 or 3."""

    @property
    def pose(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """
        (3,) target_T_source: x, y [m], yaw [rad]; of clouds in space without z, roll and pitch.
        """

    @property
    def matrix(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """(4, 4) target_T_source."""

    @property
    def covariance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """
        (3, 3) of x, y, yaw, or (6, 6) of x, y, z, rotation vector, axes of the
        target; infinite variances where no pose was found.
        """

    @property
    def status(self) -> str:
        """
        ``converged``, ``degenerate`` (a direction is open: the covariance is large
        along it), ``not_converged`` or ``too_few_pairs``: then the pose is the guess.
        """

    @property
    def method(self) -> str:
        """What gave the answer."""

    @property
    def supported(self) -> bool:
        """Whether the data support the pose."""

    @property
    def rmse_m(self) -> float:
        """Of the residuals of the pairs used."""

    @property
    def inlier_fraction(self) -> float:
        """[0, 1], share of the source's points that were paired."""

    @property
    def score(self) -> float:
        """[0, 1], share of the source that the target explains."""

    @property
    def pairs(self) -> int:
        """That were used in the end."""

    @property
    def iterations(self) -> int:
        """Of the method that gave the answer."""

    @property
    def sure(self) -> bool | None:
        """
        Of a search: the answer explains the source, and no other pose explains it
        nearly as well. None where nobody looked elsewhere: from a guess.
        """

    @property
    def complete(self) -> bool:
        """False: more places on the map look alike than were looked into."""

    @property
    def candidates(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """
        (C, 3) target_T_source, best first: the answer and what else the search found; of
        clouds in space without z, roll and pitch. None when nothing was found.
        """

    @property
    def candidate_matrices(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None, None))]:
        """(C, 4, 4) the same."""

    @property
    def candidate_scores(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(C,) score of each; NaN of a cloud's other pose, which has none."""

    @property
    def candidate_rmse_m(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """
        (C,) rmse_m of each; of a cloud's other pose over a sample of its points.
        """

    def __bool__(self) -> bool: ...

    def __repr__(self) -> str: ...

def match(source: object, target: object, robot: Robot | None, method: str, guess: numpy.typing.ArrayLike | None, search_xy_m: float | None, search_yaw_rad: float | None, anywhere: bool, options: OptionValues, threads: int) -> MatchResult: ...

class ErrorStatistics:
    """Of errors, all of one unit."""

    @property
    def mean(self) -> float:
        """Of all."""

    @property
    def std(self) -> float:
        """With n - 1."""

    @property
    def rmse(self) -> float:
        """Root of the mean square."""

    @property
    def median(self) -> float:
        """Half are larger."""

    @property
    def max(self) -> float:
        """The worst."""

    def __repr__(self) -> str: ...

class Evaluation:
    """How far a trajectory is from the truth."""

    @property
    def ate_translation_m(self) -> ErrorStatistics:
        """Absolute trajectory error [m], after the alignment."""

    @property
    def ate_rotation_rad(self) -> ErrorStatistics:
        """Of the heading [rad]."""

    @property
    def rpe_translation_m(self) -> ErrorStatistics:
        """Relative pose error [m], over the stretch that was asked for."""

    @property
    def rpe_rotation_rad(self) -> ErrorStatistics:
        """Of the heading [rad]."""

    @property
    def poses(self) -> int:
        """That were compared."""

    @property
    def poses_missing(self) -> int:
        """Reference poses outside the estimate's time."""

    @property
    def pairs(self) -> int:
        """Of the relative error."""

    @property
    def reference_T_estimate(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """(3,) the alignment that was applied."""

    @property
    def stamps_ns(self) -> Annotated[NDArray[numpy.int64], dict(shape=(None,), writable=False)]:
        """(P,) int64 [ns] of each pose that was compared, a read-only view."""

    @property
    def translation_errors_m(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)]:
        """(P,) errors of each pose that was compared [m], a read-only view."""

    @property
    def rotation_errors_rad(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)]:
        """(P,) of the heading, not negative [rad], a read-only view."""

    @property
    def rpe_stamps_ns(self) -> Annotated[NDArray[numpy.int64], dict(shape=(None,), writable=False)]:
        """(S,) int64 [ns] of each stretch, at its beginning, a read-only view."""

    @property
    def rpe_translation_errors_m(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)]:
        """(S,) errors of each stretch, at its beginning [m], a read-only view."""

    @property
    def rpe_rotation_errors_rad(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)]:
        """(S,) of the heading, not negative [rad], a read-only view."""

    def __repr__(self) -> str: ...

def evaluate(estimate: Trajectory, reference: Trajectory, align: str, rpe_delta: float, rpe_unit: str) -> Evaluation: ...

class Simulation:
    """
    What a simulated robot measured, and the truth; an iterable of its messages.
    """

    @property
    def messages(self) -> list[LaserScan | OdometryPose | WheelTicks | ImuSample | RgbdFrame]:
        """In the order of time, copied."""

    def __iter__(self) -> Iterator[LaserScan | OdometryPose | WheelTicks | ImuSample | RgbdFrame]: ...

    def __len__(self) -> int: ...

    @property
    def truth(self) -> Trajectory:
        """map_T_robot at every scan."""

    @property
    def map(self) -> GridMap:
        """The map that a perfect robot would draw."""

    @property
    def robot(self) -> Robot:
        """That drove: its mounts and wheels."""

    @property
    def scans(self) -> int:
        """How many there are."""

    @property
    def duration_s(self) -> float:
        """Of the drive [s]."""

    @property
    def route_length_m(self) -> float:
        """The way that the robot drove [m]."""

    @property
    def realism_facts(self) -> list[tuple[str, str, float]]:
        """
        (effect, name with its unit, value) of what was drawn, such as the laser's true mount.
        """

    @property
    def realism_spoils(self) -> list[tuple[str, float, float]]:
        """(effect, from, to) of what was spoilt when, since the log's start [s]."""

    @property
    def reflectors(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """
        (R, 3) x, y, radius [m] of the reflectors that found a place, on the map.
        """

    @property
    def landmarks(self) -> list[Landmark]:
        """The same as :func:`loopstone.localize` takes them."""

    def save_reflectors(self, path: str | os.PathLike[str]) -> None:
        """Writes them as ``loopstone localize --landmarks`` takes them."""

    def save(self, path: str | os.PathLike[str], format: str = 'carmen') -> None:
        """
        Writes the log, whole or not at all: ``carmen``, ``ucsd``, ``mcap``, ``bag``...
        Formats leave out what they have no place for. Raises UsageError, DataError.
        """

    def __repr__(self) -> str: ...

def simulate(world: object, robot: Robot | None, seed: int, realism: str, drive_seed: int | None, reflectors: int, options: OptionValues, progress: object | None) -> Simulation: ...

def realism_names() -> list[str]:
    """
    Effects in which the real world is less kind than a simulation, for ``realism``.
    """

def world_names() -> list[str]:
    """The worlds that there are."""
