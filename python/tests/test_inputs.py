"""Whatever is given where numbers, texts and objects are expected: an exception, never a crash."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loopstone as ls

ODD: list[Any] = [
    None,
    True,
    0,
    -1,
    2**70,
    1.5,
    float("nan"),
    float("inf"),
    "",
    "x",
    b"x",
    [],
    [[]],
    {},
    set(),
    [1, 2],
    [[1, 2], [3]],
    [1, None],
    "1,2,3",
    object(),
    np.zeros(0),
    np.zeros((0, 3)),
    np.zeros(3),
    np.full(3, np.nan),
    np.full(3, np.inf),
    np.zeros((2, 2, 2)),
    np.zeros(3, complex),
    np.zeros(3, "U1"),
    np.zeros(3, object),
    np.array([1e308, -1e308, 1e308]),
    np.zeros((3, 3))[::2, ::-1],
    np.zeros(3, ">f8"),
    np.zeros(3, np.int8),
    np.zeros((4, 3)),
    (1, 2, 3),
    np.datetime64("now"),
    range(3),
    iter([1, 2, 3]),
    memoryview(b"abc"),
]

SCAN: dict[str, Any] = dict(
    stamp_ns=1,
    ranges_m=[1.0, 2.0, 3.0],
    angle_min_rad=0.0,
    angle_increment_rad=0.1,
    range_min_m=0.0,
    range_max_m=10.0,
    time_increment_s=0.0,
    lidar=0,
    robot_T_lidar=None,
    intensities=None,
)
CALLS: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
    "LaserScan": (ls.LaserScan, SCAN),
    "points": (ls.LaserScan(**SCAN).points, dict(robot=None, velocity=None)),
    "OdometryPose": (ls.OdometryPose, dict(stamp_ns=1, odom_T_robot=[0, 0, 0])),
    "WheelTicks": (ls.WheelTicks, dict(stamp_ns=1, counts=(1, 2, 3, 4))),
    "ImuSample": (
        ls.ImuSample,
        dict(stamp_ns=1, angular_velocity_rad_s=[0, 0, 0], linear_acceleration_m_s2=[0, 0, 9.8]),
    ),
    "Trajectory": (ls.Trajectory, dict(stamps_ns=np.array([1, 2]), poses=np.zeros((2, 3)))),
    "GridMap": (
        ls.GridMap,
        dict(cells=np.zeros((3, 4), np.int8), resolution_m=0.05, origin=[0, 0]),
    ),
    "PoseGraph": (
        ls.PoseGraph,
        dict(
            poses=np.zeros((2, 3)),
            edges=np.array([[0, 1]]),
            measurements=[[1, 0, 0]],
            information=np.eye(3),
            kinds=None,
            fixed=[],
        ),
    ),
    "match": (
        ls.match,
        dict(
            source=np.eye(3)[:, :2],
            target=np.eye(3)[:, :2],
            method="icp_point",
            guess=[0, 0, 0],
            search_xy_m=None,
            anywhere=False,
            robot=None,
            options=None,
            threads=1,
        ),
    ),
    "evaluate": (
        ls.evaluate,
        dict(
            estimate="nowhere.tum",
            reference="nowhere.tum",
            align="se2",
            rpe_delta=1.0,
            rpe_unit="m",
        ),
    ),
    "open_log": (
        ls.open_log,
        dict(
            path="nowhere.log",
            robot=None,
            strict=False,
            stamps="auto",
            intensities=False,
            topics=None,
            base_frame="",
            echo="first",
            slice_m=None,
        ),
    ),
    "map": (
        ls.map,
        dict(
            log="nowhere.log",
            options=None,
            robot=None,
            start_s=0.0,
            max_scans=0,
            threads=1,
            progress=False,
        ),
    ),
    "localize": (
        ls.localize,
        dict(log="nowhere.log", map="nowhere.yaml", initial=None, seed=1, options=None),
    ),
    "optimize": (
        ls.optimize,
        dict(graph="nowhere.g2o", initial="auto", robust="none", options=None),
    ),
    "simulate": (ls.simulate, dict(world="nowhere", seed=1, robot=None, options=None)),
    "Mapper": (ls.Mapper, dict(robot=None, options=None, threads=1)),
    "Robot": (ls.Robot, dict(toml="")),
}


@pytest.mark.parametrize(
    ("call", "argument"),
    [(name, argument) for name, (_, good) in CALLS.items() for argument in good],
)
def test_odd_values_are_taken_or_refused(call: str, argument: str) -> None:
    function, good = CALLS[call]
    for value in ODD:
        try:
            function(**{**good, argument: value})
        except (ValueError, TypeError, OverflowError, OSError) as error:
            assert str(error), (call, argument, value)


def test_odd_messages_are_refused() -> None:
    mapper = ls.Mapper(threads=1)
    for value in ODD:
        with pytest.raises(TypeError, match="expected a message"):
            mapper.add(value)


def test_odd_scans_are_mapped_without_harm() -> None:
    """What a broken sensor may send: nothing of it may end the program."""
    values = [0.0, -1.0, np.nan, np.inf, -np.inf, 1e30, 3.0]
    mapper = ls.Mapper(threads=1)
    stamps = [0, 10**8, 10**8, -(10**8), 2 * 10**8, 2**61, 3 * 10**8]
    for stamp, value in itertools.product(stamps, values):
        mapper.add(
            ls.LaserScan(
                stamp,
                np.full(181, value),
                angle_min_rad=-1.57,
                angle_increment_rad=0.0174,
                range_max_m=10.0,
            )
        )
    mapper.finish()


@pytest.mark.parametrize("suffix", [".log", ".bag", ".mcap", ".g2o", ".tum", ".yaml", ".png"])
def test_noise_is_no_file(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"noise{suffix}"
    rng = np.random.default_rng(0)
    readers: list[Callable[[Path], Any]] = [
        lambda p: list(ls.open_log(p)),
        ls.read_map,
        ls.read_graph,
        ls.read_trajectory,
    ]
    for size in (0, 1, 100, 5000):
        path.write_bytes(rng.bytes(size))
        for read in readers:
            with pytest.raises(ls.DataError):
                read(path)
