from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loopstone as ls


@pytest.fixture(scope="module")
def scans(drive: ls.Simulation) -> list[ls.LaserScan]:
    return [m for m in drive if isinstance(m, ls.LaserScan)]


def test_one_scan_tells_where_it_was_taken(drive: ls.Simulation, scans: list[ls.LaserScan]) -> None:
    found = ls.relocalize(scans[80], drive.map, robot=drive.robot)
    assert found.complete and len(found) == len(found.candidates) == len(found.poses)
    distances = np.linalg.norm(found.poses[:, :2] - drive.truth.poses[80][:2], axis=1)
    assert distances.min() < 0.1
    best = found.candidates[0]
    np.testing.assert_array_equal(best.map_T_robot, found.poses[0])
    assert best.probability == found.probabilities[0] == found.probabilities.max()
    assert found.probabilities.sum() + found.none_probability <= 1.0 + 1e-9
    assert 0.5 < best.explained <= 1.0 and best.covariance.shape == (3, 3)


def test_all_candidates_are_those_of_the_program(
    drive: ls.Simulation, log: Path, tmp_path: Path, run: Any
) -> None:
    drive.map.save(tmp_path / "map.yaml")
    told = json.loads(run("relocalize", log, "--map", tmp_path / "map.yaml", "--json").stdout)
    messages = iter(ls.open_log(log))
    scan = next(m for m in messages if isinstance(m, ls.LaserScan))
    found = ls.relocalize(scan, tmp_path / "map.yaml", robot=messages.robot)
    # The program undoes the sweep by what odometry tells of the velocity, which here is next to 0.
    assert found.none_probability == pytest.approx(told["none_probability"], abs=1e-3)
    assert len(found) == len(told["candidates"])
    for candidate, expected in zip(found.candidates, told["candidates"]):
        assert candidate.probability == pytest.approx(expected["probability"], abs=1e-3)
        assert candidate.explained == pytest.approx(expected["explained"], abs=1e-3)
        assert candidate.map_T_robot[0] == pytest.approx(expected["map_T_robot"]["x_m"], abs=1e-3)


def test_several_scans_on_the_way_tell_more(
    drive: ls.Simulation, scans: list[ls.LaserScan]
) -> None:
    steps = [70, 80, 90]
    by_odometry = drive.truth.poses[steps]  # any frame will do
    found = ls.relocalize(
        [scans[i] for i in steps], drive.map, robot=drive.robot, odom_T_robot=by_odometry
    )
    assert np.linalg.norm(found.poses[0][:2] - drive.truth.poses[90][:2]) < 0.1
    with pytest.raises(ValueError, match="as many poses as scans"):
        ls.relocalize(scans[:2], drive.map, odom_T_robot=[[0, 0, 0]])


def test_elsewhere_there_is_no_candidate(drive: ls.Simulation) -> None:
    empty = ls.LaserScan(
        0, [np.inf] * 100, angle_min_rad=0.0, angle_increment_rad=0.03, range_max_m=9.0
    )
    with pytest.raises(ls.UsageError):
        ls.relocalize(empty, drive.map)
    odd = ls.LaserScan(
        0,
        [0.3 if i % 2 else 7.0 for i in range(100)],
        angle_min_rad=-1.5,
        angle_increment_rad=0.03,
        range_max_m=9.0,
    )
    found = ls.relocalize(odd, drive.map)
    assert found.none_probability > 0.9
    assert found.poses.shape == (len(found), 3)
