from __future__ import annotations

from pathlib import Path

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
