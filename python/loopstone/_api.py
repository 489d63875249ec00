"""The functions of `import loopstone`."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

from . import _core
from ._progress import ProgressLike, told
from ._values import grid_map, known_landmarks, localization_map, option_values

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .options import (
        LandmarkTrackingOptions,
        LocalizationOptions,
        MapOptions,
        Match3dOptions,
        MatchOptions,
        OptimizeOptions,
        SimulationOptions,
    )

StrPath = str | os.PathLike[str]
#: What sensors send.
Message = (
    _core.LaserScan | _core.OdometryPose | _core.WheelTicks | _core.ImuSample | _core.RgbdFrame
)
#: A map in any of its forms; a path is of a YAML file as ROS map_server reads it, of a folder with
#: one, or of a site, whose map is that of today.
MapLike = _core.GridMap | _core.OccupancyMap | _core.MapResult | _core.LocalizationMap | StrPath

#: Landmarks of known places: a CSV file with ``id,x_m,y_m`` or a folder that holds landmarks.csv,
#: UTIAS MRCLAM's, a map that found them, or one by one.
LandmarksLike = _core.MapResult | Iterable[_core.Landmark | _core.FoundLandmark] | StrPath


def open_log(
    path: StrPath,
    *,
    robot: _core.Robot | None = None,
    strict: bool = False,
    stamps: Literal["auto", "header", "record", "order"] = "auto",
    intensities: bool = False,
    topics: Mapping[str, str | Sequence[str]] | None = None,
    base_frame: str = "",
    echo: Literal["first", "strongest"] = "first",
    slice_m: tuple[float, float] | None = None,
) -> _core.Log:
    """A log: a file or a folder of any format that Loopstone reads, told by its content.

    Iterating gives its messages in the order of time, in bounded memory, and as often as it is
    asked for. Nothing is opened before.

    :param path: ``DIR#20`` names set 20 of a UCSD folder
    :param robot: wheels and mounts that beat what the log says of them
    :param strict: a broken record is an error; else it is counted and skipped
    :param stamps: whose time counts: the messages' own, the recorder's, or their order alone
    :param intensities: scans bring how bright each echo was, where the log has it
    :param topics: of a recording with topics: which play a role (``laser``, ``odometry``, ``imu``,
        ``wheels``, ``depth``, ``colour``), as in ``{"laser": "/scan"}``; an empty list leaves a
        role empty
    :param base_frame: the robot's frame in tf
    :param echo: of lasers with several echoes a beam
    :param slice_m: (low, high) of point clouds: what lies between two heights in the robot's frame
    """
    named = {
        role: [names] if isinstance(names, str) else list(names)
        for role, names in dict(topics or {}).items()
    }
    return _core.Log(path, robot, strict, stamps, intensities, named, base_frame, echo, slice_m)


def _log_of(log: StrPath | _core.Log, robot: _core.Robot | None) -> _core.Log:
    if isinstance(log, _core.Log):
        if robot is not None:
            raise TypeError("robot: give it to open_log(), since it tells how the log is read")
        return log
    return open_log(log, robot=robot)


def map(  # noqa: A001 - the word for it
    log: StrPath | _core.Log | _core.Simulation | Iterable[Message],
    *,
    options: MapOptions | Mapping[str, Any] | StrPath | None = None,
    robot: _core.Robot | None = None,
    start_s: float = 0.0,
    duration_s: float = 0.0,
    max_scans: int = 0,
    texture: bool = True,
    landmarks: bool = False,
    keep_state: bool = False,
    continue_from: _core.MapResult | StrPath | None = None,
    threads: int = 0,
    progress: ProgressLike = False,
    **overrides: Any,
) -> _core.MapResult:
    """From a log to a trajectory, a pose graph, an occupancy map and a verdict on them.

    What ``loopstone map`` makes of the same log and options, to the byte, whatever the number of
    threads.

    :param log: a path, what :func:`open_log` returns, or messages in the order of time
    :param options: :class:`loopstone.options.MapOptions`, values by their dotted keys, or the path
        of a TOML file; ``loop_closure=False`` or ``map__resolution_m=0.02`` beats them. With
        landmarks :class:`loopstone.options.LandmarkMapOptions`, which has theirs, too
    :param start_s: skip scans before this time
    :param duration_s: use so much of the log; 0: all
    :param max_scans: use so many scans; 0: all
    :param texture: the floor in colour, when the log has RGB-D
    :param landmarks: also map reflectors, by the intensities of the scans, and let them hold the
        map: ``loopstone map --landmarks``. Where the log can't show any, ``failure`` says why
    :param keep_state: the result can be gone on with, edited (:class:`MapEditor`), and saves
        state.loopstone
    :param continue_from: a map with its state, or the folder of one: the log is another drive in
        its building, which may begin anywhere in it
    :param threads: 0: one for each processor
    :param progress: True shows a bar by tqdm; or a function that is told a :class:`Progress`
    :raises DataError: nothing can be made of the log
    :raises OptionsError: with everything that is wrong with the options
    :raises KeyboardInterrupt: within a fraction of a second; nothing is left behind
    """
    kinds = ("LandmarkMapOptions", "MapOptions") if landmarks else ("MapOptions",)
    values = option_values(kinds, options, overrides)
    with told(progress) as tell:
        if isinstance(log, (str, os.PathLike, _core.Log)):
            before = continue_from if isinstance(continue_from, _core.MapResult) else None
            folder = None if isinstance(continue_from, _core.MapResult) else continue_from
            return _core.map_log(
                _log_of(log, robot),
                values,
                start_s,
                duration_s,
                max_scans,
                threads,
                texture,
                landmarks,
                keep_state,
                folder,
                before,
                tell,
            )
        if keep_state or continue_from is not None:
            raise TypeError("keep_state and continue_from are of logs, not of messages")
        if start_s or duration_s or max_scans:
            raise TypeError("start_s, duration_s and max_scans are of logs; cut the messages")
        if robot is None and isinstance(log, _core.Simulation):
            robot = log.robot
        return _core.map_messages(log, robot, values, landmarks, threads, tell)


def calibrate(
    log: StrPath | _core.Log,
    *,
    options: MapOptions | Mapping[str, Any] | StrPath | None = None,
    robot: _core.Robot | None = None,
    start_s: float = 0.0,
    duration_s: float = 0.0,
    max_scans: int = 0,
    threads: int = 0,
    progress: ProgressLike = False,
    **overrides: Any,
) -> _core.CalibrationResult:
    """How the laser sits and the wheels count, by the robot's own motion, with covariances.

    What ``loopstone calibrate`` finds. It needs odometry, and half a minute of driving with turns.

    :param options: of the mapping, as :func:`map` takes them
    :param robot: whose mounts and wheels are to be judged; None: as the log states them
    :raises DataError: nothing can be made of the log, or it tells too little
    :raises OptionsError: with everything that is wrong with the options
    """
    values = option_values("MapOptions", options, overrides)
    with told(progress) as tell:
        return _core.calibrate_log(
            _log_of(log, robot), values, start_s, duration_s, max_scans, threads, tell
        )


def convert(
    log: StrPath | _core.Log,
    path: StrPath,
    *,
    format: str | None = None,  # noqa: A002
    robot: _core.Robot | None = None,
    force: bool = False,
    progress: ProgressLike = False,
) -> _core.Conversion:
    """Writes a log in another format, whole or not at all: what ``loopstone convert`` writes.

    :param path: of the new log; its format follows from its name
    :param format: ``carmen``, ``ucsd``, ``mcap``, ``bag``..., where the name does not tell it
    :param robot: for dead reckoning, where the new format has poses and no wheel counts
    :param force: overwrite what is there
    :return: what was read, and what the new format has no place for
    :raises DataError: nothing can be made of the log
    :raises UsageError: the format is unknown or does not follow, or the new log is there already
    """
    with told(progress) as tell:
        return _core.convert(_log_of(log, robot), path, format, force, tell)


def localize(
    log: StrPath | _core.Log,
    map: MapLike | None = None,  # noqa: A002
    *,
    landmarks: LandmarksLike | None = None,
    nameless: bool = False,
    initial: ArrayLike | None = None,
    initial_sigma: tuple[float, float] = (0.5, 0.26),
    options: (
        LocalizationOptions | LandmarkTrackingOptions | Mapping[str, Any] | StrPath | None
    ) = None,
    robot: _core.Robot | None = None,
    seed: int = 1,
    calibration: bool = True,
    start_s: float = 0.0,
    duration_s: float = 0.0,
    max_scans: int = 0,
    threads: int = 0,
    progress: ProgressLike = False,
    **overrides: Any,
) -> _core.LocalizationResult:
    """Where the robot of a log was on a known map, and how sure that is.

    What ``loopstone localize`` makes of it, to the byte.

    :param landmarks: instead of a map of cells, where reflectors or beacons are: what ``loopstone
        localize --landmarks`` takes. The scans must have intensities, or the log is MRCLAM's
        folder, ``DIR#2`` its robot 2. There are no particles, so that ``seed``, ``threads`` and
        ``calibration`` change nothing
    :param nameless: of MRCLAM's: do not use which landmark was seen
    :param initial: (3,) about where it is at the first scan, x, y [m], yaw [rad]; None: anywhere
    :param initial_sigma: standard deviations of that [m, rad]
    :param options: :class:`loopstone.options.LocalizationOptions`; with landmarks
        :class:`loopstone.options.LandmarkTrackingOptions`, as ``reflectors__brightness=4.0``
    :param seed: of the particles
    :param calibration: the laser sits and goes round as the first minutes of the drive tell; else,
        and with a robot that is given, as it is told
    :raises DataError: nothing can be made of the log or the map
    :raises OptionsError: with everything that is wrong with the options
    """
    if (map is None) == (landmarks is None):
        raise TypeError(
            "on which map? map is one of cells, landmarks tells places of reflectors or beacons"
        )
    if landmarks is not None:
        values = option_values("LandmarkTrackingOptions", options, overrides)
        places = known_landmarks(landmarks)
        with told(progress) as tell:
            return _core.localize_by_landmarks(
                _log_of(log, robot),
                places,
                values,
                initial,
                *initial_sigma,
                nameless,
                start_s,
                duration_s,
                max_scans,
                tell,
            )
    if nameless:
        raise TypeError("nameless is of landmarks")
    values = option_values("LocalizationOptions", options, overrides)
    known = localization_map(map)
    with told(progress) as tell:
        return _core.localize_log(
            _log_of(log, robot),
            known,
            values,
            initial,
            *initial_sigma,
            seed,
            calibration,
            start_s,
            duration_s,
            max_scans,
            threads,
            tell,
        )


def floor_plan(
    map: _core.GridMap | _core.OccupancyMap | _core.MapResult | StrPath,  # noqa: A002
    *,
    threads: int = 0,
) -> _core.FloorPlan:
    """Draws a map as lines, rooms and doors: what ``loopstone export`` draws, to the byte.

    :param map: a folder that ``loopstone map`` or ``save`` left, a YAML file of map_server, a
        :class:`Site` or its path, or a map in memory. Lines go through what the laser measured
        where that was kept: of a folder or result with its state (``keep_state=True``), of a site,
        of a :class:`SiteMap` with ``keep_scans=True``; else through the cells, which are coarser
    :raises DataError: nothing can be made of the file
    :raises UsageError: a map without walls
    """
    if isinstance(map, (str, os.PathLike)):
        return _core.read_floor_plan(map, threads)
    if isinstance(map, _core.SiteMap) and map.has_scans:
        return _core.floor_plan_of_site_map(map, threads)
    if isinstance(map, _core.MapResult):
        return _core.floor_plan_of_result(map, threads)
    return _core.floor_plan_of_cells(grid_map(map))


def relocalize(
    scan: _core.LaserScan | Sequence[_core.LaserScan],
    map: MapLike,  # noqa: A002
    *,
    robot: _core.Robot | None = None,
    odom_T_robot: ArrayLike | None = None,
    velocity: ArrayLike | None = None,
    threads: int = 0,
) -> _core.Relocalization:
    """Where on a known map one scan may have been taken, by that scan alone.

    All poses that explain it nearly as well as the best, and how probable each is: what ``loopstone
    relocalize`` tells. A place that exists twice can't be told apart by any scan; several scans of
    a drive may.

    :param scan: or several: of lasers that look different ways, or taken on the way
    :param robot: where its lasers sit, unless the scans say so themselves
    :param odom_T_robot: (N, 3) by odometry of the robot at each scan, of several on the way; the
        answer is of the last
    :param velocity: (3,) of the robot at the scans [m/s, m/s, rad/s]; undoes the sweep
    :return: no candidates and ``none_probability`` 1 where no pose explains the scan
    :raises UsageError: a scan of fewer than 10 returns, or a map without walls
    """
    scans = [scan] if isinstance(scan, _core.LaserScan) else list(scan)
    known = localization_map(map)
    return _core.relocalize(scans, known, robot, odom_T_robot, velocity, threads)


def match(
    source: _core.LaserScan | ArrayLike,
    target: _core.LaserScan | _core.GridMap | _core.OccupancyMap | _core.MapResult | ArrayLike,
    *,
    method: Literal[
        "auto", "icp_point", "icp_line", "icp_plane", "gicp", "correlative", "grid"
    ] = "auto",
    guess: ArrayLike | None = None,
    search_xy_m: float | None = None,
    search_yaw_rad: float | None = None,
    anywhere: bool = False,
    robot: _core.Robot | None = None,
    options: MatchOptions | Match3dOptions | Mapping[str, Any] | StrPath | None = (None),
    threads: int = 1,
    **overrides: Any,
) -> _core.MatchResult:
    """Aligns a scan or a cloud to another one, or to a map.

    :param source: a LaserScan, or points (N, 2) or (N, 3) [m]; points that are not finite are
        left out
    :param target: the same, or a map. Scans are matched in the frame of the robot
    :param method: ``icp_point`` (Besl and McKay), ``icp_line`` (Censi), ``icp_plane``, ``gicp``
        (Segal), ``correlative`` (Olson; branch and bound), ``grid`` (Gauss-Newton on a grid, as
        Hector SLAM has it; of scans, and on maps); ``auto``: what suits both
    :param guess: target_T_source, (3,) x, y [m], yaw [rad]; in space (4, 4)
    :param search_xy_m: the guess may be this wrong in x and in y; in the plane
    :param search_yaw_rad: and its heading this much
    :param anywhere: search everywhere, without a guess
    :return: of which a failure is a status, never an answer that looks good
    :raises ValueError: for what are no points
    :raises UsageError: for a method that does not go with the two sides
    """
    if isinstance(target, (_core.OccupancyMap, _core.MapResult)):
        target = grid_map(target)
    kind = "Match3dOptions" if _is_3d(source) else "MatchOptions"
    values = option_values(kind, options, overrides)
    return _core.match(
        source, target, robot, method, guess, search_xy_m, search_yaw_rad, anywhere, values, threads
    )


def _is_3d(source: Any) -> bool:
    if isinstance(source, _core.LaserScan):
        return False
    import numpy as np

    try:
        shape = np.shape(source)
    except ValueError:  # rows of several lengths, of which more is said later
        return False
    return len(shape) == 2 and shape[1] == 3


def optimize(
    graph: _core.PoseGraph | StrPath,
    *,
    initial: Literal["auto", "file", "odometry", "spanning_tree", "chordal"] = "auto",
    robust: Literal["none", "huber", "cauchy", "geman_mcclure", "tukey", "dcs", "gnc"] = "none",
    certify: bool = True,
    options: OptimizeOptions | Mapping[str, Any] | StrPath | None = None,
    **overrides: Any,
) -> _core.OptimizeResult:
    """Solves a pose graph, and proves the solution optimal.

    :param graph: or the path of a file of g2o or TORO
    :param initial: where to begin; ``auto``: at the cheapest start
    :param robust: how false loop closures are softened; ``gnc`` finds out which are wrong and
        leaves them out
    :param certify: prove that the minimum is the global one, of the edges that a kernel kept; it
        costs about as much again
    :raises DataError: a file that is damaged, or a graph in parts
    :raises UsageError: a graph that makes no sense
    :raises KeyboardInterrupt: after the step that is being done
    """
    if not isinstance(graph, _core.PoseGraph):
        graph = _core.read_graph(graph)
    if robust not in ("none", "gnc"):
        overrides = {"solver.robust_kernel": robust, **overrides}
    values = option_values("OptimizeOptions", options, overrides)
    start = "" if initial == "auto" else initial
    return _core.optimize(graph, start, robust == "gnc", certify, values)


def evaluate(
    estimate: _core.Trajectory | _core.MapResult | _core.LocalizationResult | StrPath,
    reference: _core.Trajectory | StrPath,
    *,
    align: Literal["se2", "none"] = "se2",
    rpe_delta: float = 1.0,
    rpe_unit: Literal["m", "s", "frames"] = "m",
) -> _core.Evaluation:
    """How far a trajectory is from the truth: absolute and relative errors (Sturm et al. 2012).

    :param estimate: or the path of a TUM file
    :param reference: at whose stamps they are compared
    :param align: the estimate is moved onto the reference first, or not
    :param rpe_delta: over what stretch relative errors are taken, in ``rpe_unit``
    :raises UsageError: they have no time in common
    """
    return _core.evaluate(_trajectory(estimate), _trajectory(reference), align, rpe_delta, rpe_unit)


def _trajectory(
    given: _core.Trajectory | _core.MapResult | _core.LocalizationResult | StrPath,
) -> _core.Trajectory:
    if isinstance(given, (_core.MapResult, _core.LocalizationResult)):
        return given.trajectory
    if isinstance(given, _core.Trajectory):
        return given
    return _core.read_trajectory(given)


def simulate(
    world: str | MapLike = "office",
    *,
    seed: int = 1,
    drive_seed: int | None = None,
    realism: str | Iterable[str] = (),
    reflectors: int = 0,
    robot: _core.Robot | None = None,
    options: SimulationOptions | Mapping[str, Any] | StrPath | None = None,
    progress: ProgressLike = False,
    **overrides: Any,
) -> _core.Simulation:
    """What a robot measures on a drive through a world, with the truth.

    The same arguments give the same messages to the bit.

    :param world: one of :func:`world_names`, or a map
    :param seed: of the world and of all noise
    :param drive_seed: of what robot and sensors draw, instead of ``seed``: other drives in the same
        world
    :param realism: effects of :func:`realism_names`, or ``"usual"``: what every robot has every
        day; ``realism__blocked__at_s=60.0`` changes one
    :param reflectors: so many are hung where the robot sees them; scans then have intensities
    :raises UsageError: for a world that there is not, or has no room for the robot; for an effect
        that there is not
    """
    values = option_values("SimulationOptions", options, overrides)
    place: str | _core.GridMap
    if isinstance(world, str) and world in _core.world_names():
        place = world
    elif isinstance(world, str) and not os.path.exists(world):
        place = world  # the library says which there are
    else:
        place = grid_map(world)
    effects = realism if isinstance(realism, str) else ",".join(realism)
    with told(progress) as tell:
        return _core.simulate(place, robot, seed, effects, drive_seed, reflectors, values, tell)
