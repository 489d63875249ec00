"""Loopstone: 2D LiDAR SLAM, from a robot's log to a map its owner can trust.

    >>> import loopstone as ls
    >>> result = ls.map("drive.bag")
    >>> print(result.verdict)
    >>> result.save("map/")

Metres, radians, seconds; x forward, y left, yaw counter-clockwise in (-pi, pi]. ``map_T_robot``
maps coordinates of the robot to those of the map, and is written (x, y, yaw).
"""

from __future__ import annotations

from typing import TYPE_CHECKING as _TYPE_CHECKING

from ._api import (
    LandmarksLike,
    MapLike,
    Message,
    calibrate,
    convert,
    evaluate,
    localize,
    map,
    match,
    open_log,
    optimize,
    relocalize,
    simulate,
)
from ._core import (
    CalibratedValue,
    CalibrationResult,
    Certificate,
    Conversion,
    EditReport,
    ErrorStatistics,
    Evaluation,
    FloorTexture,
    FoundLandmark,
    GridMap,
    ImuSample,
    Landmark,
    LaserScan,
    LidarMount,
    LocalizationEstimate,
    LocalizationMap,
    LocalizationResult,
    Localizer,
    Log,
    LogMessages,
    LogSummary,
    LoopClosure,
    MapEditor,
    MapEvent,
    MapResult,
    MapUpdate,
    MapVerdict,
    Mapper,
    MatchResult,
    OccupancyMap,
    OdometryPose,
    OptimizeResult,
    PlaceCandidate,
    Pose,
    PoseGraph,
    QualityMeasure,
    Relocalization,
    RgbdFrame,
    Robot,
    Simulation,
    Trajectory,
    WheelCalibration,
    WheelModel,
    WheelTicks,
    read_graph,
    read_landmarks,
    read_map,
    read_trajectory,
    realism_names,
    world_names,
)
from ._core import version as __version__
from ._errors import DataError, Error, MissingFileError, OptionProblem, OptionsError, UsageError
from ._progress import Progress, ProgressLike

if _TYPE_CHECKING:
    from . import options as options


def __getattr__(name: str) -> object:
    """`loopstone.options` is read when it is first asked for: it is long."""
    if name == "options":
        import importlib

        return importlib.import_module(".options", __name__)
    raise AttributeError(f"module 'loopstone' has no attribute '{name}'")


__all__ = [
    "__version__",
    "calibrate",
    "CalibratedValue",
    "CalibrationResult",
    "Certificate",
    "Conversion",
    "convert",
    "DataError",
    "EditReport",
    "Error",
    "ErrorStatistics",
    "evaluate",
    "Evaluation",
    "FloorTexture",
    "FoundLandmark",
    "GridMap",
    "ImuSample",
    "Landmark",
    "LandmarksLike",
    "LaserScan",
    "LidarMount",
    "LocalizationEstimate",
    "LocalizationMap",
    "LocalizationResult",
    "localize",
    "Localizer",
    "Log",
    "LogMessages",
    "LogSummary",
    "LoopClosure",
    "map",
    "MapEditor",
    "MapEvent",
    "MapLike",
    "Mapper",
    "MapResult",
    "MapUpdate",
    "MapVerdict",
    "match",
    "MatchResult",
    "Message",
    "MissingFileError",
    "OccupancyMap",
    "OdometryPose",
    "open_log",
    "optimize",
    "OptimizeResult",
    "OptionProblem",
    "options",
    "OptionsError",
    "PlaceCandidate",
    "Pose",
    "PoseGraph",
    "Progress",
    "ProgressLike",
    "QualityMeasure",
    "read_graph",
    "read_landmarks",
    "read_map",
    "read_trajectory",
    "realism_names",
    "Relocalization",
    "relocalize",
    "RgbdFrame",
    "Robot",
    "simulate",
    "Simulation",
    "Trajectory",
    "UsageError",
    "WheelCalibration",
    "WheelModel",
    "WheelTicks",
    "world_names",
]
