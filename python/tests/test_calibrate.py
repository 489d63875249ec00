from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loopstone as ls


@pytest.fixture(scope="module")
def turned_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two minutes of a robot whose laser sits otherwise than its log says."""
    path = tmp_path_factory.mktemp("turned") / "drive.mcap"
    drive = ls.simulate(
        "office", seed=1, realism="mount", duration_s=120.0, laser__beams=181, laser__rate_hz=5.0
    )
    drive.save(path, "mcap")
    return path


def test_values_and_robot_are_those_of_the_program(
    turned_log: Path, tmp_path: Path, run: Any
) -> None:
    told = json.loads(
        run("calibrate", turned_log, "-o", tmp_path / "robot.toml", "--threads", 2, "--json").stdout
    )
    found = ls.calibrate(turned_log, threads=1)
    assert found.motions == told["motions"] > 40
    values = {
        "lidar.x_m": found.lidar_x_m,
        "lidar.yaw_rad": found.lidar_yaw_rad,
        "odometry.rotation_scale": found.rotation_scale,
        "laser_delay_s": found.laser_delay_s,
    }
    for key, value in values.items():
        group, _, name = key.rpartition(".")
        expected = told[group][name] if group else told[name]
        for part in ("value", "sigma", "given", "observable"):
            assert getattr(value, part) == expected[part], (key, part)
    assert found.robot.to_toml() == (tmp_path / "robot.toml").read_text()
    assert found.lidar_covariance.shape == (3, 3)
    assert found.mount_is_off == told["lidar"]["is_off"]


def test_a_given_mount_that_is_wrong_is_put_right(turned_log: Path) -> None:
    by_log = ls.calibrate(turned_log)
    assert by_log.mount_is_off
    yaw = by_log.robot.lidars[0].yaw_rad
    wrong = by_log.robot.replace({"lidars[0].yaw_rad": yaw + 0.1})
    found = ls.calibrate(ls.open_log(turned_log, robot=wrong))
    assert found.mount_is_off and found.lidar_yaw_rad.observable
    assert found.lidar_yaw_rad.given == pytest.approx(yaw + 0.1)
    assert found.robot.lidars[0].yaw_rad == pytest.approx(yaw, abs=0.01)
    assert found.robot_given.lidars[0].yaw_rad == pytest.approx(yaw + 0.1)
    right = ls.calibrate(turned_log, robot=by_log.robot)
    assert not right.mount_is_off and right.wheels is not None
    assert right.wheels.translation_scale.value == pytest.approx(1.0, abs=0.001)


def test_what_tells_nothing_is_an_error(turned_log: Path) -> None:
    with pytest.raises(ls.DataError, match="too little to calibrate by"):
        ls.calibrate(turned_log, max_scans=5)
    with pytest.raises(ls.OptionsError):
        ls.calibrate(turned_log, map__resolution_m=7.0)
    with pytest.raises(ls.MissingFileError):
        ls.calibrate("nowhere.log")


def test_a_log_becomes_what_the_program_makes_of_it(
    drive: ls.Simulation, log: Path, tmp_path: Path, run: Any
) -> None:
    run("convert", log, tmp_path / "theirs.bag", "--quiet")
    made = ls.open_log(log).save(tmp_path / "ours.bag")
    assert (tmp_path / "ours.bag").read_bytes() == (tmp_path / "theirs.bag").read_bytes()
    assert made.scans == drive.scans and made.format == "bag" and made.records_skipped == 0
    by_name = ls.convert(log, tmp_path / "text", format="carmen")
    assert by_name.format == "carmen" and any("CARMEN" in note for note in by_name.notes)
    scans = [m for m in ls.open_log(tmp_path / "text") if isinstance(m, ls.LaserScan)]
    first = next(m for m in drive if isinstance(m, ls.LaserScan))
    assert len(scans) == drive.scans
    np.testing.assert_allclose(scans[0].ranges_m, first.ranges_m, atol=0.006)


def test_nothing_is_written_over(log: Path, tmp_path: Path) -> None:
    path = tmp_path / "copy.clf"
    path.write_text("mine")
    with pytest.raises(ls.UsageError, match="is there already"):
        ls.convert(log, path)
    assert path.read_text() == "mine"
    ls.convert(log, path, force=True)
    with pytest.raises(ls.UsageError, match="the log that is read"):
        ls.convert(path, path, force=True)
    with pytest.raises(ls.UsageError):
        ls.convert(log, tmp_path / "what.xyz")
    with pytest.raises(ls.UsageError):
        ls.convert(log, tmp_path / "a", format="xyz")


def test_an_ended_conversion_leaves_nothing(long_log: Path, tmp_path: Path) -> None:
    def end(progress: ls.Progress) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        ls.open_log(long_log).save(tmp_path / "copy.mcap", progress=end)
    assert list(tmp_path.iterdir()) == []
