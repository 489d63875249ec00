"""Options, however they are written, are the same."""

from __future__ import annotations

from typing import Any

import pytest

from loopstone_fleet.options import parse_options

SAME = (("front_end.odometry", "ignore"), ("map.resolution_m", "0.02"))


@pytest.mark.parametrize(
    "given",
    [
        "map.resolution_m=0.02 front_end.odometry=ignore",
        "--set map.resolution_m=0.02 --set front_end.odometry=ignore",
        '{"map": {"resolution_m": 0.02}, "front_end.odometry": "ignore"}',
        '["map.resolution_m=0.02", "front_end.odometry=ignore"]',
        '[map]\nresolution_m = 0.02\n[front_end]\nodometry = "ignore"\n',
        'map.resolution_m = 0.02\nfront_end.odometry = "ignore"',
        {"map": {"resolution_m": 0.02}, "front_end": {"odometry": "ignore"}},
        ["front_end.odometry=ignore", "map.resolution_m=0.02"],
    ],
)
def test_every_spelling_is_the_same(given: Any) -> None:
    assert parse_options(given) == SAME


@pytest.mark.parametrize("given", [None, "", "  ", {}, "{}", "[]"])
def test_nothing_is_no_options(given: Any) -> None:
    assert parse_options(given) == ()


def test_booleans_are_words_of_the_program() -> None:
    assert parse_options('{"loop_closure": false}') == (("loop_closure", "false"),)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("resolution 0.02", "write for example"),
        ('{"a": 1', "no JSON"),
        ('{"a": [1]}', "'a' that is no number"),
        ("[1]", "has '1' where KEY=VALUE is wanted"),
        ("a=1 a=2", "a twice"),
    ],
)
def test_what_is_wrong_is_told(given: str, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        parse_options(given)
