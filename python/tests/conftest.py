"""What the tests share: a robot that was driven through an office, and its log."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

import loopstone as ls
from loopstone.__main__ import program as path_of_program

DATA = Path(os.environ.get("LOOPSTONE_DATA", "/nowhere"))


@pytest.fixture(scope="session")
def drive() -> ls.Simulation:
    """Half a minute in an office, by a laser of few beams so that tests are quick."""
    return ls.simulate("office", seed=3, duration_s=40.0, laser__beams=181, laser__rate_hz=5.0)


@pytest.fixture(scope="session")
def log(drive: ls.Simulation, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("log") / "drive.log"
    drive.save(path, "mcap")
    return path


@pytest.fixture(scope="session")
def result(log: Path) -> ls.MapResult:
    return ls.map(log)


@pytest.fixture(scope="session")
def program() -> str:
    path = os.environ.get("LOOPSTONE_PROGRAM") or path_of_program()
    assert os.path.exists(path), f"{path}: the program is not there"
    return path


@pytest.fixture(scope="session")
def run(program: str) -> Callable[..., "subprocess.CompletedProcess[str]"]:
    """Runs the program; returns what it printed."""

    def call(*arguments: object, code: int = 0) -> subprocess.CompletedProcess[str]:
        done = subprocess.run(
            [program, *(str(a) for a in arguments)], capture_output=True, text=True, check=False
        )
        assert done.returncode == code, done.stderr
        return done

    return call


@pytest.fixture(scope="session")
def long_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One that takes seconds to map."""
    path = tmp_path_factory.mktemp("long") / "drive.log"
    ls.simulate("office", seed=1, drive__laps=2).save(path, "carmen")
    return path
