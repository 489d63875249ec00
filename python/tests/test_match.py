from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import loopstone as ls

RNG = np.random.default_rng(1)
METHODS_2D = ["auto", "icp_point", "icp_line", "icp_plane", "gicp", "correlative"]


def room() -> Any:
    """Points on the walls of a room with a niche."""
    s = np.linspace(0.0, 1.0, 120)
    walls = [
        ((0, 0), (6, 0)),
        ((6, 0), (6, 4)),
        ((6, 4), (2, 4)),
        ((2, 4), (2, 5)),
        ((2, 5), (0, 5)),
        ((0, 5), (0, 0)),
    ]
    return np.vstack([np.outer(1 - s, a) + np.outer(s, b) for a, b in walls]) - [2.5, 2.0]


def moved(points: Any, pose: Any) -> Any:
    """In a frame that lies at `pose`."""
    x, y, yaw = pose
    c, s = np.cos(yaw), np.sin(yaw)
    return (points - [x, y]) @ np.array([[c, -s], [s, c]])


@pytest.mark.parametrize("method", METHODS_2D)
def test_every_method_finds_the_motion(method: Any) -> None:
    pose = np.array([0.12, -0.08, 0.05])
    target = room() + RNG.normal(scale=0.003, size=(720, 2))
    source = moved(room() + RNG.normal(scale=0.003, size=(720, 2)), pose)
    found = ls.match(source, target, method=method, guess=[0, 0, 0])
    assert found and found.status == "converged", found
    np.testing.assert_allclose(found.pose, pose, atol=0.02)
    assert found.covariance.shape == (3, 3) and found.dimension == 2
    np.testing.assert_allclose(found.matrix[:2, 3], found.pose[:2])


@pytest.mark.parametrize("method", ["auto", "icp_point", "icp_plane", "gicp"])
def test_clouds_in_space(method: Any) -> None:
    walls = []
    for axis, level in ((0, -3.0), (0, 3.0), (1, -2.0), (1, 2.5), (2, 0.0), (2, 2.2)):
        points = RNG.uniform([-3, -2, 0], [3, 2.5, 2.2], (1000, 3))
        points[:, axis] = level
        walls.append(points)
    target = np.vstack(walls)
    yaw, shift = 0.06, np.array([0.1, -0.05, 0.04])
    c, s = np.cos(yaw), np.sin(yaw)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    source = (target - shift) @ rotation
    found = ls.match(source, target, method=method, guess=np.eye(4))
    assert found.supported and found.dimension == 3
    np.testing.assert_allclose(found.matrix[:3, :3], rotation, atol=0.01)
    np.testing.assert_allclose(found.matrix[:3, 3], shift, atol=0.02)
    assert found.covariance.shape == (6, 6)


def test_scans_and_maps(drive: ls.Simulation) -> None:
    scans = [m for m in drive if isinstance(m, ls.LaserScan)]
    poses = drive.truth.poses
    found = ls.match(scans[63], scans[60])
    by_grid = ls.match(scans[63], scans[60], method="grid", guess=[0, 0, 0])
    np.testing.assert_allclose(by_grid.pose, found.pose, atol=0.02)
    c, s = np.cos(poses[60][2]), np.sin(poses[60][2])
    motion = np.array([[c, s], [-s, c]]) @ (poses[63] - poses[60])[:2]
    np.testing.assert_allclose(found.pose[:2], motion, atol=0.05)
    on_map = ls.match(scans[60], drive.map, guess=poses[60] + [0.05, -0.05, 0.02])
    np.testing.assert_allclose(on_map.pose, poses[60], atol=0.05)
    by_points = ls.match(scans[60].points(), drive.map, guess=poses[60])
    np.testing.assert_allclose(by_points.pose, poses[60], atol=0.05)


def test_a_search_tells_all_that_it_found_and_whether_it_is_sure(drive: ls.Simulation) -> None:
    scans = [m for m in drive if isinstance(m, ls.LaserScan)]
    found = ls.match(scans[80], drive.map, anywhere=True)
    assert found.sure is not None and found.complete
    np.testing.assert_array_equal(found.candidates[0], found.pose)
    np.testing.assert_array_equal(found.candidate_matrices[0], found.matrix)
    scores = found.candidate_scores
    assert len(scores) == len(found.candidates) and (np.diff(scores) <= 0.0).all()
    near = np.linalg.norm(found.candidates[:, :2] - drive.truth.poses[80][:2], axis=1)
    assert near.min() < 0.1
    guessed = ls.match(scans[80], drive.map, guess=drive.truth.poses[80])
    assert guessed.sure is None and len(guessed.candidates) == 1


def test_rooms_that_look_alike_are_not_sure() -> None:
    cells = np.zeros((120, 260), np.int8)
    for left in (10, 140):
        cells[10:110, left] = cells[10:110, left + 100] = 100
        cells[10, left : left + 101] = cells[110, left : left + 101] = 100
        cells[60:62, left : left + 40] = 100
    grid = ls.GridMap(cells, 0.05, [0.0, 0.0])
    rows, columns = np.nonzero(cells[:, :130] == 100)
    points = 0.05 * np.column_stack([columns + 0.5, rows + 0.5]) - [3.5, 2.0]
    seen = points[RNG.permutation(len(points))[:300]]
    found = ls.match(seen, grid, anywhere=True)
    assert found.sure is False and len(found.candidates) >= 2
    apart = np.abs(found.candidates[1] - found.candidates[0])
    np.testing.assert_allclose(apart[:2], [6.5, 0.0], atol=0.1)


def test_clouds_without_a_guess_tell_the_runner_up() -> None:
    square = np.vstack([[s * 2 - 1, e] for s in np.linspace(0, 1, 60) for e in (-1.0, 1.0)])
    square = np.vstack([square, square[:, ::-1]])  # fits onto itself in four ways
    found = ls.match(moved(square, [9.0, 5.0, 0.7]), square)
    if found.sure is not None:
        assert not found.sure and len(found.candidates) == 2
        assert np.isnan(found.candidate_scores[1]) and found.candidate_rmse_m[1] < 0.1


def test_no_match_is_a_status() -> None:
    far = room() + [500.0, 0.0]
    found = ls.match(room(), far, guess=[0, 0, 0], method="icp_line")
    assert not found and found.status == "too_few_pairs"
    assert np.isinf(np.diag(found.covariance)).all()
    assert found.candidates.shape == (0, 3) and found.candidate_matrices.shape == (0, 4, 4)


def test_points_without_return_are_left_out() -> None:
    target = np.vstack([room(), [[np.nan, 1.0], [np.inf, 0.0]]])
    np.testing.assert_allclose(ls.match(room(), target, guess=[0, 0, 0]).pose, 0.0, atol=1e-3)


@pytest.mark.parametrize(
    ("source", "target", "error", "words"),
    [
        ([[0.0, 1.0]], [[0.0, 1.0, 2.0]], ValueError, "source and target"),
        ([0.0, 1.0], [[0.0, 1.0]], ValueError, "source and target"),
        ([["a", "b"]], [[0.0, 1.0]], ValueError, "source: expected real numbers"),
        ([[1.0, 2.0], [1.0]], [[0.0, 1.0]], ValueError, "source: expected an array of numbers"),
        ([[1 + 2j, 0]], [[0.0, 1.0]], ValueError, "source: expected real numbers"),
        (np.full((4, 2), np.nan), [[0.0, 1.0]], ValueError, "no point with finite numbers"),
        (np.empty((0, 2)), [[0.0, 1.0]], ValueError, "no point with finite numbers"),
        (object(), [[0.0, 1.0]], ValueError, "source: expected real numbers"),
    ],
)
def test_what_are_no_points_is_refused(
    source: Any, target: Any, error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        ls.match(source, target)


def test_what_makes_no_sense_is_refused() -> None:
    scan = ls.LaserScan(0, [1.0] * 10, angle_min_rad=0.0, angle_increment_rad=0.1, range_max_m=9.0)
    with pytest.raises(ls.UsageError, match="matched to a LaserScan or to a map"):
        ls.match(scan, room())
    with pytest.raises(ls.UsageError, match="must be one of auto, icp_point"):
        ls.match(room(), room(), method="ndt")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"guess: expected an array of shape \(3,\)"):
        ls.match(room(), room(), guess=[0, 0])
    with pytest.raises(ValueError, match="guess: must hold finite numbers"):
        ls.match(room(), room(), guess=[0, 0, np.nan])
    cloud = np.column_stack([room(), room()[:, 0]])
    with pytest.raises(ValueError, match="guess: must be a rigid motion"):
        ls.match(cloud, cloud, guess=2 * np.eye(4))
    with pytest.raises(ls.OptionsError):
        ls.match(room(), room(), icp__max_iterations=0)
