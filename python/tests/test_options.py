from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loopstone as ls
from loopstone.options import (
    LandmarkMapOptions,
    LandmarkTrackingOptions,
    LocalizationOptions,
    MapOptions,
    SimulationOptions,
)

SOURCE = Path(__file__).resolve().parents[2]


def test_the_classes_are_what_the_library_says() -> None:
    script = SOURCE / "scripts" / "write_python_options.py"
    import loopstone.options

    if (
        Path(loopstone.options.__file__).read_bytes()
        != (SOURCE / "python" / "loopstone" / "options.py").read_bytes()
    ):
        pytest.fail("the package that is tested is not made of these sources")
    subprocess.run([sys.executable, script, "--check"], check=True)


@pytest.mark.parametrize(
    ("command", "kind"),
    [
        ("map", MapOptions),
        ("landmark_map", LandmarkMapOptions),
        ("localize", LocalizationOptions),
        ("landmarks", LandmarkTrackingOptions),
    ],
)
def test_defaults_are_those_of_the_program(command: str, kind: Any, run: Any) -> None:
    assert kind().to_toml() == run("config", command).stdout


def test_help_is_that_of_the_program(run: Any) -> None:
    printed = run("config").stdout
    for entry in ls._core.describe_options("map"):
        first = entry["help"].split(" ")[0]
        assert first in printed


def test_only_what_was_changed_is_told() -> None:
    options = MapOptions()
    assert options.changed() == {}
    options.map.resolution_m = 0.1
    options.loop_closure = False
    assert options.changed() == {"map.resolution_m": 0.1, "loop_closure": False}
    assert dataclasses.replace(options, loop_closure=True).loop_closure


def test_a_misspelled_field_is_no_field() -> None:
    with pytest.raises(TypeError):
        MapOptions(loop_closures=False)  # type: ignore[call-arg]
    with pytest.raises(AttributeError):
        MapOptions().map.resolution = 0.1  # type: ignore[attr-defined]


def test_all_problems_are_told_at_once() -> None:
    options = MapOptions()
    options.map.resolution_m = 7.0
    options.front_end.odometry = "never"  # type: ignore[assignment]
    options.map.hit_probability = float("nan")
    with pytest.raises(ls.OptionsError) as caught:
        options.check()
    assert {p.key for p in caught.value.problems} == {
        "map.resolution_m",
        "front_end.odometry",
        "map.hit_probability",
    }
    assert "map.resolution_m = 7.0: must be a number from 0.005 to 1" in str(caught.value)
    assert isinstance(caught.value, ValueError)


def test_an_unknown_key_names_the_nearest(log: Path, run: Any, tmp_path: Path) -> None:
    with pytest.raises(ls.OptionsError, match="map.resolution_m") as caught:
        ls.map(log, map__resolution=0.1)
    told = run("map", log, "-o", tmp_path / "out", "--set", "map.resolution=0.1", code=2).stderr
    (problem,) = caught.value.problems
    assert problem.rule in told


def test_problems_of_a_file_have_its_line(log: Path, tmp_path: Path) -> None:
    path = tmp_path / "options.toml"
    path.write_text("loop_closure = true\n[map]\nresolution_m = 7\n")
    with pytest.raises(ls.OptionsError) as caught:
        ls.map(log, options=path, map__hit_probability=2)
    assert [(p.source, p.line) for p in caught.value.problems] == [
        (str(path), 3),
        ("options", None),
    ]


def test_numbers_of_numpy_are_numbers() -> None:
    numbers: dict[str, Any] = {"duration_s": np.float64(2.5), "people": np.int32(1)}
    options = SimulationOptions(**numbers)
    assert "duration_s = 2.5" in options.to_toml()


def test_options_of_another_call_are_refused(log: Path) -> None:
    with pytest.raises(TypeError, match="expected MapOptions, not LocalizationOptions"):
        ls.map(log, options=LocalizationOptions())  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="expected MapOptions"):
        ls.map(log, options=3)  # type: ignore[arg-type]
