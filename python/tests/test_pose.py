from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import loopstone as ls

RNG = np.random.default_rng(4)


def any_pose() -> ls.Pose:
    return ls.Pose(*RNG.uniform(-3.0, 3.0, 3))


def test_composition_is_the_product_of_matrices() -> None:
    for _ in range(20):
        a, b = any_pose(), any_pose()
        np.testing.assert_allclose((a @ b).matrix, a.matrix @ b.matrix, atol=1e-12)
        np.testing.assert_allclose(a.inverse().matrix, np.linalg.inv(a.matrix), atol=1e-12)
        np.testing.assert_allclose(a @ a.between(b), b, atol=1e-12)
        np.testing.assert_allclose(ls.Pose.exp(a.twist), a, atol=1e-9)
        np.testing.assert_allclose(a.interpolate(b, 1.0), b, atol=1e-9)
        np.testing.assert_allclose(a.interpolate(b, 0.0), a, atol=1e-12)


def test_points_are_moved_by_the_matrix() -> None:
    pose = ls.Pose(1.0, 2.0, np.pi / 2)
    points = RNG.normal(size=(50, 2))
    by_matrix = (np.column_stack([points, np.ones(50)]) @ pose.matrix.T)[:, :2]
    np.testing.assert_allclose(pose @ points, by_matrix, atol=1e-12)
    np.testing.assert_array_equal(pose.transform(points), pose @ points)
    np.testing.assert_allclose(pose @ [1.0, 0.0], [1.0, 3.0], atol=1e-12)
    assert (pose @ np.empty((0, 2))).shape == (0, 2)
    assert np.isnan(pose.transform([[np.nan, 0.0]])).all()
    for wrong in (np.zeros((4, 3)), np.zeros(3), np.zeros((2, 2, 2))):
        with pytest.raises(ValueError, match=r"points: expected an array of shape \(N, 2\)"):
            pose.transform(wrong)


def test_a_pose_is_three_numbers_wherever_one_is_taken(result: ls.MapResult) -> None:
    pose = ls.Pose.of(result.trajectory.poses[-1])
    assert list(pose) == [pose.x, pose.y, pose.yaw] == [pose[0], pose[1], pose[-1]]
    assert len(pose) == 3
    np.testing.assert_array_equal(np.asarray(pose), result.trajectory.poses[-1])
    path = ls.Trajectory([0, 1], [ls.Pose(), pose])
    np.testing.assert_array_equal(path.poses[1], pose)
    with pytest.raises(IndexError):
        pose[3]
    assert np.asarray(pose, dtype=np.float32).dtype == np.float32


def test_poses_are_values() -> None:
    pose = ls.Pose(1.0, 2.0, 3.0 * np.pi)
    assert pose.yaw == pytest.approx(np.pi) and pose == ls.Pose.of([1.0, 2.0, pose.yaw])
    assert pose != ls.Pose() and pose != "a pose" and len({pose, ls.Pose.of(pose)}) == 1
    assert eval(repr(pose), {"Pose": ls.Pose}) == pose
    with pytest.raises(AttributeError):
        pose.x = 3.0  # type: ignore[misc]
    with pytest.raises(ValueError, match="finite"):
        ls.Pose(np.nan, 0.0, 0.0)
    with pytest.raises(ValueError, match=r"pose: expected an array of shape \(3,\)"):
        ls.Pose.of([1.0, 2.0])
    array: Any = np.eye(3)
    with pytest.raises(TypeError):
        array @ pose  # of which NumPy would make a product of matrices
