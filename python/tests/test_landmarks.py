"""Reflectors and beacons: found by a map, and localised by."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loopstone as ls
from loopstone.options import LandmarkMapOptions, LocalizationOptions


@pytest.fixture(scope="module")
def lit() -> ls.Simulation:
    """Some seconds in an office with reflectors."""
    return ls.simulate("office", seed=3, reflectors=120, duration_s=15.0)


@pytest.fixture(scope="module")
def lit_log(lit: ls.Simulation, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("lit") / "log.mcap"
    lit.save(path, "mcap")
    lit.save_reflectors(path.parent / "truth.csv")
    return path


@pytest.fixture(scope="module")
def dark_log(lit: ls.Simulation, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same in a format that does not tell how bright echoes are."""
    path = tmp_path_factory.mktemp("dark") / "log.clf"
    lit.save(path, "carmen")
    return path


@pytest.fixture(scope="module")
def found(lit_log: Path) -> ls.MapResult:
    return ls.map(lit_log, landmarks=True, threads=2)


def test_the_map_is_that_of_the_program(
    found: ls.MapResult, lit_log: Path, tmp_path: Path, run: Any
) -> None:
    run("map", lit_log, "-o", tmp_path / "theirs", "--landmarks", "--threads", 1, "--quiet")
    found.save(tmp_path / "ours")
    for name in ("landmarks.csv", "trajectory.tum", "graph.g2o", "map.pgm", "options.toml"):
        ours = (tmp_path / "ours" / name).read_bytes()
        assert ours == (tmp_path / "theirs" / name).read_bytes(), name
    assert {p.name for p in (tmp_path / "ours").iterdir()} == {
        p.name for p in (tmp_path / "theirs").iterdir()
    }
    assert found.summary["landmarks"]["count"] == len(found.landmarks) > 8
    assert found.failure == ""
    read = ls.read_landmarks(tmp_path / "ours")
    assert [one.id for one in read] == [one.id for one in found.landmarks]
    np.testing.assert_allclose(read[0].position, found.landmarks[0].position, atol=1e-6)


def test_found_landmarks_are_where_reflectors_hang(found: ls.MapResult, lit: ls.Simulation) -> None:
    # The map begins at the first pose.
    begin = ls.Pose.of(found.trajectory.poses[0])
    world_T_map = ls.Pose.of(lit.truth.poses[0]) @ begin.inverse()
    true_places = np.array([one.position for one in lit.landmarks])
    np.testing.assert_array_equal(true_places, lit.reflectors[:, :2])
    for one in found.landmarks:
        assert one.covariance.shape == (2, 2) and one.sigma_m > 0.0
        assert one.sightings >= 4 and one.visits >= 1
        assert repr(one).startswith(f"<FoundLandmark {one.id} at (")
        place = world_T_map @ np.array([one.position])
        assert np.linalg.norm(true_places - place, axis=1).min() < 0.15, one
    np.testing.assert_array_equal(
        found.graph.landmarks, np.array([one.position for one in found.landmarks])
    )


def test_messages_have_landmarks_too(found: ls.MapResult, lit: ls.Simulation) -> None:
    made = ls.map(lit, landmarks=True)
    assert len(made.landmarks) == pytest.approx(len(found.landmarks), abs=3)
    assert len(made.landmarks) > 8


def test_landmarks_are_asked_for(lit_log: Path, dark_log: Path, found: ls.MapResult) -> None:
    plain = ls.map(lit_log, max_scans=30)
    assert plain.landmarks == [] and "landmarks" not in plain.summary
    dark = ls.map(dark_log, landmarks=True, max_scans=30)
    assert dark.landmarks == [] and "the scans have no intensities" in dark.failure
    assert not dark.summary["complete"] and dark.failure in dark.summary["warnings"]
    with pytest.raises(ls.UsageError, match="leave out keep_state"):
        ls.map(lit_log, landmarks=True, keep_state=True)
    with pytest.raises(ls.UsageError, match="leave out keep_state"):
        ls.map(lit_log, landmarks=True, continue_from=found)


def test_options_of_landmarks_count(lit_log: Path) -> None:
    options = LandmarkMapOptions()
    options.landmarks.sightings_min = 50
    options.loop_closure = False
    few = ls.map(lit_log, landmarks=True, options=options)
    assert "sightings_min = 50" in few.options_toml and "loop_closure = false" in few.options_toml
    same = ls.map(lit_log, landmarks=True, landmarks__sightings_min=50, loop_closure=False)
    assert [one.id for one in same.landmarks] == [one.id for one in few.landmarks]
    assert all(one.sightings >= 50 for one in few.landmarks)
    with pytest.raises(ls.OptionsError, match="landmarks.sightings_min"):
        ls.map(lit_log, landmarks=True, landmarks__sightings_min=1)
    with pytest.raises(TypeError, match="expected MapOptions, not LandmarkMapOptions"):
        ls.map(lit_log, options=options)


def test_the_robot_is_where_the_program_has_it(
    lit: ls.Simulation, lit_log: Path, tmp_path: Path, run: Any
) -> None:
    csv = lit_log.parent / "truth.csv"
    made = ls.localize(lit_log, landmarks=csv)
    run(
        "localize",
        lit_log,
        "--landmarks",
        csv,
        "-o",
        tmp_path / "where.tum",
        "--report",
        tmp_path / "theirs",
        "--global",
        "--quiet",
    )
    assert made.trajectory.to_tum() == (tmp_path / "where.tum").read_text()
    made.save(tmp_path / "ours")
    for name in ("localization.csv", "options.toml", "map.png"):
        ours = (tmp_path / "ours" / name).read_bytes()
        assert ours == (tmp_path / "theirs" / name).read_bytes(), name
    assert made.estimates[-1].state == "TRACKING"
    errors = ls.evaluate(made, lit.truth, align="none")
    assert errors.ate_translation_m.rmse < 0.05
    guessed = ls.localize(lit_log, landmarks=csv, initial=lit.truth.poses[0])
    assert guessed.summary["start"] != made.summary["start"]


def test_landmarks_come_in_many_forms(
    lit: ls.Simulation, lit_log: Path, found: ls.MapResult, tmp_path: Path
) -> None:
    found.save(tmp_path / "map")
    places = [
        ls.Landmark(one.id, *one.position, sigma_m=one.sigma_m, radius_m=one.radius_m)
        for one in found.landmarks
    ]
    paths = [
        ls.localize(lit_log, landmarks=given).trajectory.to_tum()
        for given in (found, found.landmarks, places)
    ]
    assert len(set(paths)) == 1 and paths[0]
    folder = ls.localize(lit_log, landmarks=tmp_path / "map").trajectory  # of fewer digits
    read = ls.localize(lit_log, landmarks=ls.read_landmarks(tmp_path / "map")).trajectory
    assert folder.to_tum() == read.to_tum()
    whole = ls.localize(lit_log, landmarks=found).trajectory
    np.testing.assert_allclose(folder.poses, whole.poses, atol=1e-4)
    surveyed = ls.localize(lit_log, landmarks=lit.landmarks).trajectory.to_tum()
    by_file = ls.localize(lit_log, landmarks=lit_log.parent / "truth.csv").trajectory.to_tum()
    assert surveyed == by_file != paths[0]


def test_what_can_not_be_is_said(
    lit: ls.Simulation, lit_log: Path, dark_log: Path, result: ls.MapResult, tmp_path: Path
) -> None:
    known = lit.landmarks
    assert repr(ls.Landmark(4, 1.5, -2.0)) == "<Landmark 4 at (1.500, -2.000) m>"
    with pytest.raises(TypeError, match="on which map"):
        ls.localize(lit_log)
    with pytest.raises(TypeError, match="on which map"):
        ls.localize(lit_log, lit.map, landmarks=known)
    with pytest.raises(TypeError, match="nameless"):
        ls.localize(lit_log, lit.map, nameless=True)
    with pytest.raises(TypeError, match="landmarks: expected"):
        ls.localize(lit_log, landmarks=[(1.0, 2.0)])  # type: ignore[list-item]
    with pytest.raises(TypeError, match="landmarks: expected"):
        ls.localize(lit_log, landmarks=3)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="this map has none"):
        ls.localize(lit_log, landmarks=result)
    with pytest.raises(ls.UsageError):
        ls.localize(lit_log, landmarks=[known[0], known[0]])
    with pytest.raises(ls.UsageError):
        ls.localize(lit_log, landmarks=[])
    with pytest.raises(ls.MissingFileError):
        ls.localize(lit_log, landmarks=tmp_path / "none.csv")
    with pytest.raises(ls.DataError, match="no intensities"):
        ls.localize(dark_log, landmarks=known)
    with pytest.raises(ls.DataError, match="no beam is bright enough"):
        ls.localize(lit_log, landmarks=known, reflectors__brightness=900)
    with pytest.raises(ls.OptionsError, match="reflectors.brightness"):
        ls.localize(lit_log, landmarks=known, reflectors__brightness=0.2)
    with pytest.raises(TypeError, match="expected LandmarkTrackingOptions"):
        ls.localize(lit_log, landmarks=known, options=LocalizationOptions())


@pytest.fixture(scope="module")
def mrclam(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder as MRCLAM has them: a robot on a circle among six landmarks, each in its turn."""
    folder = tmp_path_factory.mktemp("mrclam")
    places = [(4.0, 0.5), (2.5, 3.6), (-1.8, 4.1), (-4.4, -0.7), (-1.2, -3.9), (3.1, -2.8)]
    pose = ls.Pose(2.0, 0.0, math.pi / 2)
    odometry, measured = [], []
    for step in range(1200):
        time_s = 1000.0 + 0.05 * step
        odometry.append(f"{time_s:.3f} 0.2 0.1")
        if step % 6 == 0:
            i = step // 6 % len(places)
            x, y = (pose.inverse() @ np.array([places[i]]))[0]
            measured.append(f"{time_s:.3f} {10 * (i + 1)} {math.hypot(x, y)} {math.atan2(y, x)}")
        pose = pose @ ls.Pose(0.01, 0.0, 0.005)
    barcodes = ["1 5"] + [f"{i + 6} {10 * (i + 1)}" for i in range(len(places))]
    truth = [f"{i + 6} {x} {y} 0.0001 0.0001" for i, (x, y) in enumerate(places)]
    for name, lines in {
        "Barcodes.dat": barcodes,
        "Landmark_Groundtruth.dat": truth,
        "Robot1_Odometry.dat": odometry,
        "Robot1_Measurement.dat": measured,
    }.items():
        (folder / name).write_text("\n".join(lines) + "\n")
    return folder


@pytest.mark.parametrize("nameless", [False, True])
def test_beacons_tell_as_by_the_program(
    mrclam: Path, nameless: bool, tmp_path: Path, run: Any
) -> None:
    made = ls.localize(mrclam, landmarks=mrclam, nameless=nameless)
    flags = ["--nameless"] if nameless else []
    out = tmp_path / "where.tum"
    run("localize", mrclam, "--landmarks", mrclam, "-o", out, "--global", "--quiet", *flags)
    assert made.trajectory.to_tum() == out.read_text()
    other = ls.localize(mrclam, landmarks=mrclam, nameless=not nameless)
    assert not np.array_equal(other.probability, made.probability)  # names find the first place
    with pytest.raises(ls.UsageError, match="no scans"):
        ls.map(mrclam, landmarks=True)
