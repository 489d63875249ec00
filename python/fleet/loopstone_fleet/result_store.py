"""The folder of a fleet's results: maps by what they were made of, and a row for each log.

    OUT/results/ab/abcd.../    what `map` wrote, under the hash of log, options and version
    OUT/rows/12/1234....json   how a log ended, under the id of its entry
    OUT/work/                  what is being made; empty between runs
    OUT/fleet.parquet, fleet.html

Whatever has its final name is whole: it was made under another and renamed.
"""

from __future__ import annotations

import json
import os
import shutil
import socket
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from loopstone_fleet.errors import FleetError

Row = dict[str, Any]
SUMMARY = "summary.json"
# By then the last worker has seen that its run was stopped.
STOPPED_S = 24 * 3600.0


class ResultStore:
    """Results, rows and work of one OUT. Several machines may share it."""

    def __init__(self, out: Path) -> None:
        self.out = out

    def make(self) -> None:
        """Makes its folders. FleetError where that is not possible."""
        try:
            for name in ("results", "rows", "work"):
                (self.out / name).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FleetError(f"{error.filename}: cannot be made: {error.strerror}") from None

    # ---- results

    def result(self, key: str) -> Path:
        return self.out / "results" / key[:2] / key

    def summary(self, key: str) -> Row | None:
        """The figures of a result; None where there is no whole one."""
        summary = read_json(self.result(key) / SUMMARY)
        return summary if summary is not None and summary.get("complete") is True else None

    def publish(self, folder: Path, key: str, replaces: bool = False) -> None:
        """Gives a finished result its name. Where another worker was faster, its own stays: both
        are the same bytes. A result that is replaced goes with the folder that `folder` is in."""
        target = self.result(key)
        target.parent.mkdir(parents=True, exist_ok=True)
        if target.exists() and self.summary(key) is None:  # damaged by hand, or by a lost disk
            shutil.rmtree(target)
        if replaces and target.exists():
            target.rename(folder.with_name("replaced"))
        try:
            folder.rename(target)
        except OSError:
            if self.summary(key) is None:
                raise

    # ---- rows

    def row_path(self, entry_id: str) -> Path:
        return self.out / "rows" / entry_id[:2] / f"{entry_id}.json"

    def row(self, entry_id: str) -> Row | None:
        return read_json(self.row_path(entry_id))

    def write_row(self, row: Row) -> None:
        path = self.row_path(row["id"])
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, json.dumps(row, ensure_ascii=False, indent=1).encode())

    def rows(self) -> Iterator[Row]:
        """All rows, by id."""
        for folder in sorted((self.out / "rows").glob("*")):
            for path in sorted(folder.glob("*.json")):
                row = read_json(path)
                if row is not None:
                    yield row

    # ---- work

    @contextmanager
    def work_folder(self) -> Iterator[Path]:
        """A folder for one try, removed afterwards. Its name tells whose it is."""
        name = f"{socket.gethostname()}-{os.getpid()}-{uuid.uuid4().hex[:12]}"
        folder = self.out / "work" / name
        folder.mkdir(parents=True)
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def sweep_work(self, patience_s: float = 0.0) -> None:
        """Removes what workers of this machine left that were killed; those that are about to end
        have `patience_s` for it."""
        until = time.monotonic() + patience_s
        while self._sweep_folders() and time.monotonic() < until:
            time.sleep(0.05)
        for path in (self.out / "work").glob("stop-*"):
            if time.time() - path.stat().st_mtime > STOPPED_S:
                path.unlink(missing_ok=True)

    def _sweep_folders(self) -> int:
        """How many are left, of workers that live."""
        kept = 0
        for folder in (self.out / "work").glob(f"{socket.gethostname()}-*-*"):
            pid = folder.name.rsplit("-", 2)[1]
            if not pid.isdigit():
                continue
            if is_running(int(pid)):
                kept += 1
            else:
                shutil.rmtree(folder, ignore_errors=True)
        return kept


def is_running(pid: int) -> bool:
    """Whether a process of this machine has not ended, be it that nobody asked for its end yet."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state not in "ZX"


def read_json(path: Path) -> Row | None:
    """An object; None where there is none, or a damaged one."""
    try:
        value = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return None
    return value if isinstance(value, dict) else None


def write_whole(path: Path, data: bytes) -> None:
    """Writes a file that is there as a whole or not at all."""
    partial = path.with_name(f".{path.name}.{os.getpid()}-{uuid.uuid4().hex[:8]}.partial")
    try:
        with partial.open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
