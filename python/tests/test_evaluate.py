from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loopstone as ls


def path(noise: float = 0.0) -> ls.Trajectory:
    rng = np.random.default_rng(2)
    t = np.arange(200)
    poses = np.column_stack([0.1 * t, np.sin(0.05 * t), 0.3 * np.cos(0.05 * t)])
    return ls.Trajectory(
        t * 100_000_000, poses + rng.normal(scale=noise, size=poses.shape) * (noise > 0)
    )


def test_errors_by_pose_are_views_of_what_the_figures_are_of() -> None:
    estimate = path(0.02)
    found = ls.evaluate(estimate, path(), align="none", rpe_delta=10, rpe_unit="frames")
    errors = found.translation_errors_m
    assert len(errors) == found.poses and not errors.flags.writeable
    expected = np.linalg.norm(estimate.poses[:, :2] - path().poses[:, :2], axis=1)
    np.testing.assert_allclose(errors, expected, atol=1e-12)
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(found.ate_translation_m.rmse)
    assert found.rotation_errors_rad.max() == found.ate_rotation_rad.max
    np.testing.assert_array_equal(found.stamps_ns, path().stamps_ns)
    assert len(found.rpe_translation_errors_m) == found.pairs == len(found.rpe_stamps_ns)
    assert found.rpe_rotation_errors_rad.max() == found.rpe_rotation_rad.max
    assert found.rpe_translation_errors_m.mean() == pytest.approx(found.rpe_translation_m.mean)
    del found
    assert errors.max() > 0.0  # lives on


def test_errors_are_those_of_the_program(tmp_path: Path, run: Any) -> None:
    path(0.02).save(tmp_path / "estimate.tum")
    path().save(tmp_path / "truth.tum")
    told = json.loads(
        run(
            "evaluate",
            "--estimate",
            tmp_path / "estimate.tum",
            "--reference",
            tmp_path / "truth.tum",
            "--json",
        ).stdout
    )
    ours = ls.evaluate(tmp_path / "estimate.tum", tmp_path / "truth.tum")
    assert ours.ate_translation_m.rmse == pytest.approx(told["ate_rmse_m"], rel=1e-12)
    assert ours.ate_rotation_rad.rmse == pytest.approx(told["ate_rmse_rad"], rel=1e-12)
    assert ours.poses == 200 and ours.pairs > 0 and ours.poses_missing == 0


def test_a_moved_trajectory_is_moved_back() -> None:
    truth = path()
    moved = truth.poses + [3.0, -1.0, 0.0]
    shifted = ls.Trajectory(np.array(truth.stamps_ns), moved)
    assert ls.evaluate(shifted, truth).ate_translation_m.max < 1e-9
    assert ls.evaluate(shifted, truth, align="none").ate_translation_m.mean == pytest.approx(
        np.hypot(3, 1)
    )
    np.testing.assert_allclose(
        ls.evaluate(shifted, truth).reference_T_estimate, [-3, 1, 0], atol=1e-9
    )


def test_text_and_interpolation(tmp_path: Path) -> None:
    truth = path()
    truth.save(tmp_path / "truth.tum")
    assert (tmp_path / "truth.tum").read_text() == truth.to_tum()
    read = ls.read_trajectory(tmp_path / "truth.tum")
    np.testing.assert_array_equal(read.stamps_ns, truth.stamps_ns)
    np.testing.assert_allclose(read.poses, truth.poses, atol=1e-8)
    middle = truth.at(50_000_000)
    assert middle is not None
    np.testing.assert_allclose(middle[0], 0.05, atol=1e-3)
    assert truth.at(-1) is None
    assert truth.path_length_m > 19.0


@pytest.mark.parametrize(
    ("stamps", "poses", "words"),
    [
        (np.array([0, 0]), np.zeros((2, 3)), "must increase"),
        (np.array([0, 1]), np.zeros((3, 3)), "as many"),
        (np.array([0, 1]), np.zeros((2, 2)), "poses: expected"),
        (np.array([0, 1]), np.full((2, 3), np.nan), "poses: must hold finite"),
    ],
)
def test_what_is_no_trajectory_is_refused(stamps: Any, poses: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ls.Trajectory(stamps, poses)


def test_what_can_not_be_compared_is_refused() -> None:
    truth = path()
    later = ls.Trajectory(np.array(truth.stamps_ns) + 10**12, np.array(truth.poses))
    with pytest.raises(ls.UsageError, match="no time in common"):
        ls.evaluate(later, truth)
    with pytest.raises(ls.UsageError, match="align = sim3"):
        ls.evaluate(truth, truth, align="sim3")  # type: ignore[arg-type]
    with pytest.raises(ls.UsageError, match="rpe_delta"):
        ls.evaluate(truth, truth, rpe_delta=0.0)
