from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loopstone as ls


def test_the_same_seed_gives_the_same_drive() -> None:
    one, two = (ls.simulate("rooms", seed=4, duration_s=4.0, laser__beams=61) for _ in range(2))
    np.testing.assert_array_equal(one.truth.poses, two.truth.poses)
    for a, b in zip(one, two):
        assert type(a) is type(b) and a.stamp_ns == b.stamp_ns
        if isinstance(a, ls.LaserScan) and isinstance(b, ls.LaserScan):
            np.testing.assert_array_equal(a.ranges_m, b.ranges_m)
    assert one.scans == len(one.truth) > 0
    assert len(one) == len(one.messages)


def test_all_sensors_measure(drive: ls.Simulation) -> None:
    kinds = {type(message) for message in drive}
    assert kinds == {ls.LaserScan, ls.WheelTicks, ls.ImuSample}
    ticks = next(m for m in drive if isinstance(m, ls.WheelTicks))
    assert len(ticks.counts) == 4
    imu = next(m for m in drive if isinstance(m, ls.ImuSample))
    assert imu.linear_acceleration_m_s2[2] == pytest.approx(9.8, abs=0.5)
    told = ls.simulate("office", duration_s=2.0, laser__beams=61, odometry_poses=True)
    pose = next(m for m in told if isinstance(m, ls.OdometryPose))
    assert pose.odom_T_robot.shape == (3,)


def test_a_map_is_a_world(drive: ls.Simulation) -> None:
    inside = ls.simulate(drive.map, duration_s=2.0, laser__beams=61)
    assert inside.scans > 0
    np.testing.assert_array_equal(inside.map.cells, drive.map.cells)


def test_the_world_is_as_unkind_as_is_asked_for(tmp_path: Path, run: Any) -> None:
    assert {"mount", "blocked", "upside_down"} <= set(ls.realism_names())
    small: dict[str, Any] = {"duration_s": 8.0, "laser__beams": 61}
    drive = ls.simulate("office", seed=2, realism="usual", **small)
    assert {effect for effect, _, _ in drive.realism_facts} >= {"mount"}
    blind = ls.simulate("office", seed=2, realism=["blocked"], realism__blocked__at_s=3.0, **small)
    assert [(effect, from_s) for effect, from_s, _ in blind.realism_spoils] == [("blocked", 3.0)]
    assert ls.simulate("office", seed=2, **small).realism_spoils == []
    words = "simulate office --seed 2 --duration 8 --beams 61 --realism bent,usual --format carmen"
    run(*words.split(), "-o", tmp_path / "sim", "--drive-seed", 5, "--quiet")
    bent = ls.simulate("office", seed=2, drive_seed=5, realism=["bent", "usual"], **small)
    assert bent.truth.to_tum() == (tmp_path / "sim" / "truth.tum").read_text()
    np.testing.assert_array_equal(bent.map.cells, ls.read_map(tmp_path / "sim" / "map.yaml").cells)
    with pytest.raises(ls.UsageError, match="fog"):
        ls.simulate("office", realism="fog")


def test_another_drive_in_the_same_world() -> None:
    one, two = (
        ls.simulate("rooms", seed=4, drive_seed=s, duration_s=3.0, laser__beams=61) for s in (4, 9)
    )
    plain = ls.simulate("rooms", seed=4, duration_s=3.0, laser__beams=61)
    np.testing.assert_array_equal(one.map.cells, two.map.cells)
    ranges = [[m.ranges_m for m in d if isinstance(m, ls.LaserScan)] for d in (one, two, plain)]
    np.testing.assert_array_equal(ranges[0], ranges[2])
    assert not np.array_equal(ranges[0], ranges[1])


def test_reflectors_are_seen_as_bright_echoes(tmp_path: Path) -> None:
    drive = ls.simulate("office", reflectors=12, duration_s=3.0, laser__beams=361)
    assert drive.reflectors.shape == (12, 3)
    scan = next(m for m in drive if isinstance(m, ls.LaserScan))
    assert scan.intensities is not None
    drive.save_reflectors(tmp_path / "landmarks.csv")
    assert len((tmp_path / "landmarks.csv").read_text().splitlines()) >= 12
    assert ls.simulate("office", duration_s=1.0, laser__beams=61).reflectors.shape == (0, 3)
    with pytest.raises(ls.UsageError, match="reflectors"):
        ls.simulate("office", reflectors=-1)


@pytest.mark.parametrize("format", ["carmen", "ucsd", "mcap"])
def test_logs_are_written_in_many_formats(format: str, tmp_path: Path) -> None:
    drive = ls.simulate("office", duration_s=3.0, laser__beams=61)
    drive.save(tmp_path / "log", format)
    read = [m for m in ls.open_log(tmp_path / "log") if isinstance(m, ls.LaserScan)]
    assert len(read) == drive.scans


def test_what_there_is_not_is_refused(tmp_path: Path) -> None:
    assert "office" in ls.world_names()
    with pytest.raises(ls.UsageError, match="castle"):
        ls.simulate("castle")
    with pytest.raises(ls.OptionsError, match="duration_s"):
        ls.simulate("office", duration_s=-1.0)
    with pytest.raises(ls.UsageError):
        ls.simulate("office", duration_s=1.0).save(tmp_path / "log", "vhs")
