"""A program that fails as it is told, and the real one where it is built."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest

from loopstone_fleet.main import main
from loopstone_fleet.result_store import ResultStore

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent


class Fleet:
    """A folder with logs, and calls of the command upon it."""

    def __init__(self, folder: Path, program: Path) -> None:
        self.folder, self.program = folder, program
        self.out = folder / "out"
        self.calls = folder / "calls"
        self.calls.mkdir()
        (folder / "logs").mkdir()

    def log(self, name: str, text: str = "ok") -> Path:
        """A log that tells the fake program what to do."""
        path = self.folder / "logs" / name
        path.write_text(f"{text}\n{name}\n")
        return path

    def manifest(self, lines: Iterable[str], header: str = "log") -> Path:
        path = self.folder / "logs.csv"
        path.write_text("\n".join([header, *lines]) + "\n")
        return path

    def manifest_of_all(self) -> Path:
        return self.manifest(str(path) for path in sorted((self.folder / "logs").iterdir()))

    def run(self, manifest: Path, *flags: str) -> int:
        return main(
            ["run", str(manifest), "-o", str(self.out), "--program", str(self.program), "--pause"]
            + ["0.05", *flags]
        )

    def rows(self) -> dict[str, dict[str, Any]]:
        """By the name of the log; each has one."""
        rows = list(ResultStore(self.out).rows())
        names = Counter(Path(row["log"]).name for row in rows)
        assert all(count == 1 for count in names.values()), names
        return {Path(row["log"]).name: row for row in rows}

    def statuses(self) -> dict[str, str]:
        return {name: row["status"] for name, row in self.rows().items()}

    def times_mapped(self, name: str) -> int:
        path = self.calls / name
        return len(path.read_text().splitlines()) if path.exists() else 0


@pytest.fixture
def fleet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Fleet:
    program = tmp_path / "loopstone"
    text = (HERE / "fake_loopstone.py").read_text()
    # By this very interpreter, and at once.
    program.write_text(f"#!{sys.executable} -IS\n{text}")
    program.chmod(0o755)
    made = Fleet(tmp_path, program)
    monkeypatch.setenv("CALLS", str(made.calls))
    return made


def real_program() -> Path:
    given = os.environ.get("LOOPSTONE_PROGRAM", str(ROOT / "build/release/bin/loopstone"))
    if shutil.which(given) is None:
        pytest.skip(f"the program is not built: {given}")
    return Path(given)


@pytest.fixture
def real_fleet(tmp_path: Path) -> Fleet:
    return Fleet(tmp_path, real_program())


def simulate(fleet: Fleet, name: str, seed: int, *flags: str) -> Path:
    """A short drive as one CARMEN file."""
    folder = fleet.folder / f"sim-{seed}"
    subprocess.run(
        [str(fleet.program), "simulate", "office", "-o", str(folder), "--format", "carmen"]
        + ["--beams", "91", "--fov", "180", "--scan-rate", "5", "--duration", "12", "--quiet"]
        + ["--seed", str(seed), *flags],
        check=True,
        capture_output=True,
    )
    return Path(shutil.move(str(folder / "log.clf"), fleet.folder / "logs" / name))
