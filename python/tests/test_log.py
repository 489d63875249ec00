from __future__ import annotations

import gc
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loopstone as ls


def scans_of(messages: Any) -> list[ls.LaserScan]:
    return [m for m in messages if isinstance(m, ls.LaserScan)]


def test_messages_come_in_the_order_of_time_and_as_often_as_asked(log: Path) -> None:
    opened = ls.open_log(log)
    first = [m.stamp_ns for m in opened]
    assert first == sorted(first)
    assert first == [m.stamp_ns for m in opened]


def test_messages_are_those_that_were_written(drive: ls.Simulation, log: Path) -> None:
    written, read = scans_of(drive), scans_of(ls.open_log(log))
    assert len(written) == len(read) > 100
    for ours, theirs in zip(written, read):
        assert ours.stamp_ns == theirs.stamp_ns
        np.testing.assert_array_equal(ours.ranges_m, theirs.ranges_m)


def test_ranges_are_a_view_that_outlives_the_scan(log: Path) -> None:
    scan = scans_of(ls.open_log(log))[0]
    ranges = scan.ranges_m
    assert ranges.dtype == np.float32 and ranges.shape == (len(scan),)
    assert not ranges.flags.writeable and not ranges.flags.owndata
    address = ranges.__array_interface__["data"][0]
    assert scan.ranges_m.__array_interface__["data"][0] == address
    before = ranges.copy()
    del scan
    gc.collect()
    np.testing.assert_array_equal(ranges, before)
    with pytest.raises(ValueError):
        ranges[0] = 1.0


def test_points_are_where_the_beams_end() -> None:
    scan = ls.LaserScan(
        5,
        [1.0, np.inf, 2.0, np.nan],
        angle_min_rad=0.0,
        angle_increment_rad=np.pi / 4,
        range_max_m=10.0,
        robot_T_lidar=[0.1, 0.0, 0.0],
    )
    np.testing.assert_allclose(scan.points(), [[1.1, 0.0], [0.1, 2.0]], atol=1e-6)
    np.testing.assert_allclose(scan.angles_rad, np.arange(4) * np.pi / 4)
    assert repr(scan) == "<LaserScan at 0.000000 s, 4 beams>"


def test_summary_is_what_the_program_tells(log: Path, run: Any) -> None:
    summary = ls.open_log(log).summary()
    told = json.loads(run("info", log, "--json").stdout)
    assert summary.to_dict(str(log)) == told
    assert summary.counts["laser"] == summary.scans
    assert summary.duration_s == pytest.approx(40.0, abs=1.0)
    assert all(severity != "error" for severity, _ in summary.findings)


def test_a_reader_tells_how_far_it_is_and_of_the_robot(log: Path) -> None:
    messages = iter(ls.open_log(log))
    assert messages.robot.robot_T_lidars.shape == (1, 3)
    for _ in messages:
        pass
    done, total = messages.bytes_read
    assert 0 < done <= total
    assert messages.records_skipped == 0


def test_a_given_robot_beats_the_log(log: Path) -> None:
    robot = ls.Robot('[[lidars]]\nname = "front"\nx_m = 0.5\n')
    scan = scans_of(ls.open_log(log, robot=robot))[0]
    assert scan.robot_T_lidar is None
    assert robot.robot_T_lidars[0, 0] == 0.5


def test_what_is_no_log_is_told_as_the_program_tells_it(tmp_path: Path, run: Any) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("nothing that a robot wrote\n")
    with pytest.raises(ls.DataError) as caught:
        next(iter(ls.open_log(path)))
    assert caught.value.path == str(path)
    assert str(caught.value) in run("info", path, code=1).stderr


def test_a_missing_file_is_a_file_not_found_error(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught:
        ls.map(tmp_path / "drive.log")
    assert isinstance(caught.value, ls.DataError)


def test_a_wrong_word_names_the_right_ones(log: Path) -> None:
    with pytest.raises(ls.UsageError, match="must be one of auto, header, record, order"):
        ls.open_log(log, stamps="recorder")  # type: ignore[arg-type]
    with pytest.raises(ls.UsageError, match="'lidar' is no role"):
        ls.open_log(log, topics={"lidar": "/scan"})
    with pytest.raises(ls.UsageError, match="the lower first"):
        ls.open_log(log, slice_m=(1.0, 0.5))


def test_strict_reading_says_where_the_damage_is(tmp_path: Path) -> None:
    path = tmp_path / "damaged.log"
    ls.simulate("office", duration_s=5.0, laser__beams=91).save(path, "carmen")
    lines = path.read_text().splitlines()
    lines[40] = lines[40][: len(lines[40]) // 2]
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(ls.DataError) as caught:
        list(ls.open_log(path, strict=True))
    assert caught.value.line == 41
    messages = iter(ls.open_log(path))
    assert len(list(messages)) > 0
    assert messages.records_skipped == 1
