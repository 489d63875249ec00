"""The guide says what is so: statuses, flags, columns."""

from __future__ import annotations

import re

import pytest

from conftest import ROOT, Fleet
from loopstone_fleet.main import main
from loopstone_fleet.manifest import COLUMNS
from loopstone_fleet.status import STATUSES

PAGE = ROOT / "docs/fleet.md"


def table_after(heading: str) -> list[str]:
    """The first cells of the first table after a heading, without code marks."""
    text = PAGE.read_text().split(heading, 1)[1]
    rows = re.findall(r"^\| (.*?) \|", text.split("\n\n| ", 1)[1].split("\n\n")[0], re.M)
    return [name for row in rows for name in re.findall(r"`([\w.]+)`", row)]


def test_every_status_is_explained() -> None:
    assert table_after("### What is skipped") == list(STATUSES)
    assert table_after("## The manifest") == list(COLUMNS)


def test_flags_exist(capsys: pytest.CaptureFixture[str]) -> None:
    helps = ""
    for command in ("run", "manifest", "merge", "report"):
        with pytest.raises(SystemExit):
            main([command, "--help"])
        helps += capsys.readouterr().out
    known = set(re.findall(r"--[a-z-]+", helps))
    code = PAGE.read_text().replace("\\\n", " ")
    calls = re.findall(r"loopstone-fleet (?:run|manifest|merge|report)\b([^\n`#&]*)", code)
    given = {flag for call in calls for flag in re.findall(r"--[a-z-]+", call.split(" -- ")[0])}
    assert {"--levels", "--max-memory", "--shard", "--timeout", "--workers"} <= given <= known


def test_columns_are_those_of_rows(fleet: Fleet) -> None:
    log = fleet.log("a")
    assert fleet.run(fleet.manifest([f"{log},hall"], "log,site")) == 0
    told = set(table_after("## Rows and table"))
    summary = {"duration_s", "scans", "quality", "odometry_faults", "warnings"}
    assert told == set(fleet.rows()["a"]) - summary - set(COLUMNS)


@pytest.mark.parametrize("word", ["Slurm", "Kubernetes", "Dask", "Ray"])
def test_ways_to_many_machines_are_told(word: str) -> None:
    assert word in PAGE.read_text()
