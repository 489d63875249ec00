from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loopstone as ls


def test_files_are_those_of_the_program(
    drive: ls.Simulation, log: Path, tmp_path: Path, run: Any
) -> None:
    drive.map.save(tmp_path / "map.yaml")
    initial = drive.truth.poses[0]
    made = ls.localize(log, tmp_path / "map.yaml", initial=initial, seed=5, calibration=False)
    start = ",".join(repr(float(v)) for v in initial)
    run(
        "localize",
        log,
        "--map",
        tmp_path / "map.yaml",
        "-o",
        tmp_path / "path.tum",
        "--initial",
        start,
        "--seed",
        "5",
        "--no-calibration",
        "--quiet",
    )
    assert made.trajectory.to_tum() == (tmp_path / "path.tum").read_text()
    made.save(tmp_path / "report")
    assert (tmp_path / "report" / "trajectory.tum").read_text() == made.trajectory.to_tum()


def test_a_laser_that_sits_otherwise_is_found_as_by_the_program(tmp_path: Path, run: Any) -> None:
    sim, out = tmp_path / "sim", tmp_path / "where.tum"
    run("simulate", "office", "-o", sim, "--realism", "upside_down", "--duration", 45, "--quiet")
    made = ls.localize(sim, sim, seed=2)
    run("localize", sim, "--map", sim, "-o", out, "--global", "--seed", 2, "--quiet")
    assert made.trajectory.to_tum() == out.read_text()
    assert any("hangs upside down" in warning for warning in made.warnings)
    as_told = ls.localize(sim, sim, seed=2, calibration=False)
    assert as_told.trajectory.to_tum() != out.read_text()


def test_it_finds_the_robot_and_knows_it(drive: ls.Simulation, log: Path) -> None:
    made = ls.localize(log, drive.map)
    errors = ls.evaluate(made, drive.truth, align="none")
    assert made.estimates[-1].state == "TRACKING"
    assert made.probability[-1] > 0.9
    last = np.array(made.trajectory.poses[-1])
    assert np.hypot(*(last - drive.truth.poses[-1])[:2]) < 0.1
    assert errors.poses > 0
    assert made.covariances.shape == (len(made.trajectory), 3, 3)
    assert made.summary["scans"] == drive.scans


def test_every_estimate_tells_all_places(tmp_path: Path) -> None:
    drive = ls.simulate("rooms", duration_s=12.0, laser__beams=181, laser__rate_hz=5.0)
    drive.save(tmp_path / "drive.mcap", "mcap")
    made = ls.localize(tmp_path / "drive.mcap", drive.map, calibration=False)
    for estimate in made.estimates:
        assert len(estimate.places) == len(estimate.place_probabilities) == estimate.hypotheses
        assert estimate.place_probabilities.sum() == pytest.approx(1.0)
        assert (np.diff(estimate.place_probabilities) <= 1e-12).all()
    assert max(e.hypotheses for e in made.estimates) > 1  # the rooms are alike
    last = made.estimates[-1]
    np.testing.assert_allclose(last.places[0][:2], last.map_T_robot[:2], atol=0.3)


def test_online_is_the_same(drive: ls.Simulation, log: Path) -> None:
    known = ls.LocalizationMap(drive.map)
    initial = drive.truth.poses[0]
    messages = iter(ls.open_log(log))
    localizer = ls.Localizer(known, messages.robot, initial=initial)
    estimates = [e for message in messages for e in localizer.add(message)]
    assert localizer.particles.shape[1] == 3
    made = localizer.finish()
    assert len(estimates) <= len(made.estimates)
    whole = ls.localize(log, known, initial=initial)
    np.testing.assert_array_equal(made.trajectory.poses, whole.trajectory.poses)
    with pytest.raises(ls.UsageError, match="finished"):
        localizer.finish()


def test_maps_come_in_many_forms(result: ls.MapResult, log: Path, tmp_path: Path) -> None:
    assert result.map is not None
    result.save(tmp_path / "out")
    paths = [
        ls.localize(log, given, initial=[0, 0, 0], max_scans=20).trajectory.poses
        for given in (result, result.map, result.map.to_grid(), tmp_path / "out")
    ]
    for path in paths[1:]:
        np.testing.assert_array_equal(path, paths[0])


def test_a_map_without_walls_is_no_map(log: Path) -> None:
    nothing = ls.GridMap(np.full((20, 20), -1, np.int8), 0.05, [0, 0])
    with pytest.raises(ls.UsageError):
        ls.localize(log, nothing)
    with pytest.raises(TypeError, match="map: expected"):
        ls.localize(log, 3)  # type: ignore[arg-type]
