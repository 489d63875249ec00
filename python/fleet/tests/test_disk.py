"""A disk that is full: nothing is lost, nothing half is taken for whole."""

from __future__ import annotations

import errno
import os
import subprocess
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from conftest import Fleet, real_program, simulate
from loopstone_fleet.result_store import ResultStore


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 3 MB, where one can be made."""
    folder = tmp_path / "small"
    folder.mkdir()
    made = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=3m", "tmpfs", str(folder)], capture_output=True
    )
    if made.returncode != 0:
        pytest.skip("no small file system can be mounted here, which needs root")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def fill(folder: Path) -> Path:
    path = folder / "filler"
    with path.open("wb", buffering=0) as file:
        try:
            while True:
                file.write(bytes(4096))
        except OSError as error:
            assert error.errno == errno.ENOSPC
    return path


def test_the_real_program_on_a_full_disk(tmp_path: Path, small_disk: Path) -> None:
    fleet = Fleet(tmp_path, real_program())
    fleet.out = small_disk / "out"
    names = [f"{seed}.clf" for seed in range(1, 7)]
    for seed, name in enumerate(names, 1):
        simulate(fleet, name, seed)
    manifest = fleet.manifest_of_all()
    assert fleet.run(manifest, "--retries", "1") == 1
    rows = fleet.rows()
    # Whose row found no room is told, and is there after the next run.
    assert {row["status"] for row in rows.values()} <= {"done", "disk_full"}
    done = [name for name, row in rows.items() if row["status"] == "done"]
    assert 0 < len(done) < len(names)
    for row in rows.values():
        if row["status"] == "done":
            assert ResultStore(fleet.out).summary(Path(row["result"]).name) is not None
    assert list(fleet.out.rglob("*.partial")) == []
    subprocess.run(["mount", "-o", "remount,size=64m", str(small_disk)], check=True)
    assert fleet.run(manifest) == 0
    assert fleet.statuses() == dict.fromkeys(names, "done")


def test_a_run_waits_for_space(fleet: Fleet, small_disk: Path) -> None:
    fleet.out = small_disk / "out"
    for number in range(4):
        fleet.log(f"log{number}")
    manifest = fleet.manifest_of_all()
    ResultStore(fleet.out).make()
    filler = fill(small_disk)

    def make_room() -> None:
        time.sleep(1.0)
        filler.unlink()

    thread = threading.Thread(target=make_room)
    thread.start()
    code = fleet.run(manifest, "--pause", "0.4", "--retries", "4", "--workers", "2")
    thread.join()
    assert code == 0
    assert set(fleet.statuses().values()) == {"done"}
    assert all(fleet.times_mapped(f"log{number}") >= 1 for number in range(4))


def test_a_disk_that_stays_full_ends_a_run(
    fleet: Fleet, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for number in range(5):
        fleet.log(f"log{number}")
    manifest = fleet.manifest_of_all()

    def write_row(self: ResultStore, row: dict[str, object]) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(ResultStore, "write_row", write_row)
        assert fleet.run(manifest, "--retries", "2", "--workers", "2") == 1
    assert "5 rows could not be written" in capsys.readouterr().err
    assert fleet.rows() == {}
    assert fleet.run(manifest) == 0
    assert {row["reused"] for row in fleet.rows().values()} == {True}
    assert fleet.times_mapped("log0") == 1


def test_rows_wait_where_the_disk_takes_none(fleet: Fleet, monkeypatch: pytest.MonkeyPatch) -> None:
    for number in range(3):
        fleet.log(f"log{number}")
    manifest = fleet.manifest_of_all()
    refused: list[str] = []
    write = ResultStore.write_row

    def write_row(self: ResultStore, row: dict[str, object]) -> None:
        if len(refused) < 2:
            refused.append(str(row["log"]))
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        write(self, row)

    monkeypatch.setattr(ResultStore, "write_row", write_row)
    assert fleet.run(manifest) == 0
    assert len(refused) == 2
    assert set(fleet.statuses().values()) == {"done"}
    assert all(fleet.times_mapped(f"log{number}") == 1 for number in range(3))
