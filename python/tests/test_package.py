from __future__ import annotations

import subprocess
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest

import loopstone as ls

HEAVY = ("numpy", "matplotlib", "pandas", "networkx", "gtsam", "tqdm")


def test_import_brings_nothing_heavy() -> None:
    script = "import sys, loopstone; print(*sorted(set(sys.argv[1:]) & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", script, *HEAVY], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == []


def test_the_version_is_that_of_the_program(run: Any) -> None:
    assert ls.__version__ in run("--version").stdout
    try:
        assert metadata.version("loopstone") == ls.__version__
    except metadata.PackageNotFoundError:
        pytest.skip("the package is tried in place")


def test_what_is_exported_is_documented() -> None:
    for name in ls.__all__:
        if name not in {"__version__", "Message", "MapLike", "ProgressLike"}:
            assert getattr(ls, name).__doc__, name
    assert "open_log" in ls.__all__ and "Any" not in ls.__all__


def test_the_package_is_typed() -> None:
    folder = Path(ls.__file__).parent
    assert (folder / "py.typed").exists()
    stub = (folder / "_core.pyi").read_text()
    assert "class MapResult" in stub and "nanobind" not in stub


def test_the_program_comes_with_it(program: str) -> None:
    by_module = subprocess.run(
        [sys.executable, "-m", "loopstone", "--version"], capture_output=True, text=True
    )
    if by_module.returncode != 0 and "not where it should be" in by_module.stderr:
        pytest.skip("the package is tried in place")
    direct = subprocess.run([program, "--version"], capture_output=True, text=True)
    assert by_module.stdout == direct.stdout
    bad = subprocess.run([sys.executable, "-m", "loopstone", "map"], capture_output=True, text=True)
    assert bad.returncode == 2


def test_results_say_what_they_are(result: ls.MapResult, drive: ls.Simulation) -> None:
    assert repr(result).startswith("<MapResult of ")
    assert repr(drive) == f"<Simulation of {drive.scans} scans>"
    assert str(result.verdict).startswith(result.verdict.overall)
    assert result.robot.to_toml()
