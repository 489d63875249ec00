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

from ._api import MapLike, Message, evaluate, localize, map, match, open_log, optimize, simulate
from ._core import (
    Certificate,
    ErrorStatistics,
    Evaluation,
    GridMap,
    ImuSample,
    LaserScan,
    LocalizationEstimate,
    LocalizationMap,
    LocalizationResult,
    Localizer,
    Log,
    LogMessages,
    LogSummary,
    LoopClosure,
    MapEvent,
    MapResult,
    MapUpdate,
    MapVerdict,
    Mapper,
    MatchResult,
    OccupancyMap,
    OdometryPose,
    OptimizeResult,
    PoseGraph,
    QualityMeasure,
    RgbdFrame,
    Robot,
    Simulation,
    Trajectory,
    WheelTicks,
    __version__,
    read_graph,
    read_map,
    read_trajectory,
    world_names,
)
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


__all__ = [name for name in globals() if not name.startswith("_") or name == "__version__"]
__all__.remove("annotations")
__all__.append("options")
