"""Dask and Ray on loopback: the same rows as on this machine, also when workers are killed."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from conftest import Fleet
from loopstone_fleet import executors

os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")


def need(module: str) -> None:
    if importlib.util.find_spec(module) is None:
        pytest.skip(f"{module} is not installed")


@pytest.fixture(params=["dask", "ray"])
def executor(request: pytest.FixtureRequest) -> str:
    need("distributed" if request.param == "dask" else "ray")
    return str(request.param)


def test_workers_that_are_killed_lose_nothing(fleet: Fleet, executor: str) -> None:
    words = {
        "fine1": "ok",
        "fine2": "ok",
        "fine3": "ok",
        "poison": "crash",
        "hangs": "hang",
        "killed_once": "once kill_parent",
        "kills_workers": "kill_parent",
    }
    for name, word in words.items():
        fleet.log(name, word)
    flags = ["--executor", executor, "--workers", "2", "--timeout", "5", "--retries", "1"]
    manifest = fleet.manifest_of_all()
    assert fleet.run(manifest, *flags, "--max-memory", "256M") == 1
    assert fleet.statuses() == {
        "fine1": "done",
        "fine2": "done",
        "fine3": "done",
        "poison": "crashed",
        "hangs": "timeout",
        "killed_once": "done",
        "kills_workers": "worker_failed",
    }
    rows = fleet.rows()
    assert rows["kills_workers"]["attempts"] == 2
    # Dask forgives a log one dead worker by itself, Ray none.
    assert fleet.times_mapped("kills_workers") == (4 if executor == "dask" else 2)
    assert fleet.times_mapped("poison") == 1
    assert rows["fine1"]["worker"] != f"{rows['fine1']['worker'].split(':')[0]}:{os.getpid()}"
    # A worker that died could not tidy up; the next run does.
    (fleet.folder / "logs" / "kills_workers").write_text("ok\n")
    assert fleet.run(manifest, "--timeout", "5") == 0
    assert fleet.times_mapped("fine1") == 1
    assert list((fleet.out / "work").iterdir()) == []


@pytest.fixture
def dask_cluster(tmp_path: Path) -> Iterator[str]:
    """A scheduler with a worker, as others run them; its address."""
    need("distributed")
    told = tmp_path / "scheduler.json"
    environment = {**os.environ, "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1"}

    def begin(part: str, *flags: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.{part}", "--scheduler-file", str(told)]
        return subprocess.Popen(
            [*command, "--no-dashboard", *flags],
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    scheduler = begin("dask_scheduler", "--host", "127.0.0.1", "--port", "0")
    worker = begin("dask_worker", "--nthreads", "1", "--local-directory", str(tmp_path))
    try:
        deadline = time.monotonic() + 30
        while not told.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        yield json.loads(told.read_text())["address"]
    finally:
        for process in (worker, scheduler):  # a worker asks its scheduler whether it may go
            process.terminate()
            process.wait(20)


def test_a_cluster_that_runs_already(fleet: Fleet, dask_cluster: str) -> None:
    fleet.log("a")
    fleet.log("b", "once kill_parent")
    flags = ["--executor", "dask", "--address", dask_cluster, "--retries", "0"]
    assert fleet.run(fleet.manifest_of_all(), *flags) == 0
    # Here the scheduler itself gave the log to a new worker.
    assert fleet.statuses() == {"a": "done", "b": "done"}
    assert fleet.times_mapped("b") == 2


def test_workers_come_and_go(monkeypatch: pytest.MonkeyPatch) -> None:
    answers = [0, 3, 5]
    workers = executors.Workers(lambda: answers.pop(0))
    assert [workers.count(), workers.count()] == [1, 1]
    monkeypatch.setattr(executors, "ASKED_EVERY_S", -1.0)
    assert [workers.count(), workers.count()] == [3, 5]


def test_a_cluster_that_is_not_there(
    fleet: Fleet, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    need("distributed")
    monkeypatch.setattr("loopstone_fleet.executors.dask.CONNECT_S", 1)
    fleet.log("a")
    flags = ["--executor", "dask", "--address", "127.0.0.1:1"]
    assert fleet.run(fleet.manifest_of_all(), *flags) == 2
    assert "no Dask scheduler answers" in capsys.readouterr().err
