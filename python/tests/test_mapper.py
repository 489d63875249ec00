from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import loopstone as ls


def test_a_live_map_ends_as_that_of_the_log(log: Path, result: ls.MapResult) -> None:
    messages = iter(ls.open_log(log))
    mapper = ls.Mapper(messages.robot)
    updates = [update for message in messages for update in mapper.add(message)]
    assert [u.scan for u in updates] == list(range(len(updates)))
    assert mapper.scans >= len(updates)
    live = mapper.live_map()
    assert live.observed.any()
    assert len(mapper.key_poses) > 0
    made = mapper.finish()
    np.testing.assert_array_equal(made.trajectory.poses, result.trajectory.poses)
    assert made.map is not None and result.map is not None
    np.testing.assert_array_equal(made.map.log_odds, result.map.log_odds)


def test_updates_tell_where_the_robot_is(drive: ls.Simulation) -> None:
    mapper = ls.Mapper(drive.robot)
    truth = drive.truth
    kinds = set()
    for message in drive:
        for update in mapper.add(message):
            assert update.status in {"tracked", "degenerate", "bridged", "lost"}
            assert update.covariance.shape == (3, 3)
            kinds |= {event.kind for event in update.events}
            right = truth.at(update.stamp_ns)
            start = truth.poses[0]
            assert right is not None
            # Both are told from the first pose.
            distance = np.hypot(*(right - start)[:2])
            assert np.hypot(*update.map_T_robot[:2]) == pytest.approx(distance, abs=0.3)
    assert "submap_opened" in kinds
    mapper.finish()


def test_a_finished_mapper_takes_nothing_more(drive: ls.Simulation) -> None:
    mapper = ls.Mapper(drive.robot)
    messages = drive.messages
    for message in messages[:200]:
        mapper.add(message)
    mapper.finish()
    with pytest.raises(ls.UsageError, match="finished"):
        mapper.add(messages[200])
    with pytest.raises(ls.UsageError, match="finished"):
        mapper.finish()


def test_a_second_drive_joins_the_first(drive: ls.Simulation) -> None:
    mapper = ls.Mapper(drive.robot)
    for _ in range(2):
        mapper.begin_drive()
        for message in drive:
            mapper.add(message)
    result = mapper.finish()
    assert len(result.trajectory) == 2 * drive.scans


def test_options_are_those_of_map() -> None:
    with pytest.raises(ls.OptionsError):
        ls.Mapper(options={"map.resolution_m": 7.0})
    with pytest.raises(ls.OptionsError):
        ls.Mapper(map__resolution_m=7.0)


def test_what_is_no_message_is_refused() -> None:
    with pytest.raises(TypeError, match="expected a message"):
        ls.Mapper().add("scan")  # type: ignore[arg-type]
