"""Table, page, listing, progress and the command line around them."""

from __future__ import annotations

import io
import json
import re
import shutil
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pyarrow.parquet as parquet
import pytest

from conftest import ROOT, Fleet
from loopstone_fleet import __version__
from loopstone_fleet.listing import write_listing
from loopstone_fleet.main import main
from loopstone_fleet.outputs import Renewal
from loopstone_fleet.overview import overview_of
from loopstone_fleet.page import State, page_of
from loopstone_fleet.progress import Progress, duration_text
from loopstone_fleet.table import flat, list_of, read_table, write_table


def row(number: int, **figures: Any) -> dict[str, Any]:
    base = {
        "id": f"{number:024}",
        "log": f"/logs/r/{number}.bag",
        "robot": "",
        "status": "done",
        "program_version": "1.0.0",
        "result": f"results/ab/{number}",
        "duration_s": 100.0,
        "quality": {"verdict": "good"},
    }
    return {**base, **figures}


# ---- the table


def test_a_table_has_a_column_for_every_figure_of_any_row(tmp_path: Path) -> None:
    rows = [
        row(1, scans=5, share=1, faults=[{"fault": "stuck"}]),
        row(2, share=0.5, nothing=None, mixed="text", quality={"verdict": "bad", "deep": {"x": 1}}),
        row(3, mixed=7, flag=True),
    ]
    path = tmp_path / "t.parquet"
    assert write_table(lambda: rows, path) == 3
    table = parquet.read_table(path)
    types = {field.name: str(field.type) for field in table.schema}
    assert types["scans"] == "int64" and types["share"] == "double" and types["flag"] == "bool"
    assert types["mixed"] == "string" and types["nothing"] == "double"
    columns = table.to_pydict()
    assert columns["scans"] == [5, None, None]
    assert columns["share"] == [1.0, 0.5, None]
    assert columns["quality.deep.x"] == [None, 1, None]
    assert columns["faults.count"] == [1, None, None]
    assert json.loads(columns["faults"][0]) == list_of(columns["faults"][0]) == rows[0]["faults"]
    again = tmp_path / "again.parquet"
    write_table(lambda: read_table(path), again)
    columns.pop("nothing")  # that no row has
    assert parquet.read_table(again).to_pydict() == columns


def test_a_table_of_nothing_is_one(tmp_path: Path) -> None:
    path = tmp_path / "t.parquet"
    assert write_table(lambda: [], path) == 0
    assert list(read_table(path)) == []


def test_large_tables_are_written_in_groups(tmp_path: Path) -> None:
    path = tmp_path / "t.parquet"
    assert write_table(lambda: (row(number) for number in range(3_500)), path) == 3_500
    assert parquet.ParquetFile(path).num_row_groups == 4
    assert [each["id"] for each in read_table(path)] == [f"{n:024}" for n in range(3_500)]


# ---- the page


class Checker(HTMLParser):
    """Counts what is opened and closed, and collects texts and links."""

    VOID = ("meta", "br", "img")

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.links: list[str] = []
        self.texts: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        if tag not in self.VOID:
            self.open.append(tag)
        self.links += [value or "" for name, value in attributes if name in ("href", "src")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def checked(page: str) -> Checker:
    checker = Checker()
    checker.feed(page)
    assert checker.open == []
    return checker


def fault(kind: str) -> list[dict[str, str]]:
    return [{"fault": kind}, {"fault": kind}]


def test_the_page_names_robots_that_need_service() -> None:
    rows = [
        *(row(n, robot="sound") for n in range(9)),
        row(10, robot="sound", odometry_faults=fault("stuck")),
        *(row(20 + n, robot="sick", odometry_faults=fault("lagging")) for n in range(2)),
        *(row(30 + n, robot="sick", odometry_distrusted_s=50.0) for n in range(2)),
        *(row(40 + n, robot="blind", laser_faults=fault("covered")) for n in range(3)),
        *(row(50 + n, robot="bent", calibration={"lidar": {"yaw_is_off": True}}) for n in range(2)),
        row(60, robot="fine"),
        row(61, robot="new", status="crashed", reason="signal 11", result=None),
    ]
    over = overview_of(rows)
    verdicts = {name: robot.verdict for name, robot in over.robots.items()}
    assert verdicts == {
        "sound": "watch",
        "sick": "service",
        "blind": "service",
        "bent": "watch",
        "fine": "fine",
        "new": "fine",
    }
    assert over.robots["sick"].faults == {"odometry lagging": 2}
    text = " ".join(checked(page_of(over, State(False, 0))).texts)
    assert "2 robots need service" in text
    assert re.search(r"sick\s+service\s+4\s+2\s+25%\s+odometry lagging in 2", text)
    assert "signal 11" in text


def test_the_page_leads_to_doubtful_maps_and_tells_reasons() -> None:
    bad = {"verdict": "bad", "possible_error_m": 3.0, "sentence": "Walls <twice>."}
    rows = [
        row(1, quality={"verdict": "doubtful", "possible_error_m": 9.0, "sentence": "Loose."}),
        row(2, quality=bad, process_wall_s=50.0),
        row(3, status="timeout", reason="was not done after <5> s", result=None),
    ]
    page = page_of(overview_of(rows), State(False, 0))
    checker = checked(page)
    assert checker.links.index("results/ab/2/report.html") < checker.links.index(
        "results/ab/1/report.html"
    )
    text = " ".join(checker.texts)
    assert "was not done after <5> s" in text and "Walls <twice>." in text
    assert "0% of 2 maps are good; 1 log gave none." in text
    assert "Logs in /logs/r/." in text


def test_the_page_of_a_run_renews_itself() -> None:
    over = overview_of([row(1)])
    assert "refresh" in page_of(over, State(True, 10))
    assert "1 of 10 logs so far" in page_of(over, State(True, 10))
    assert "refresh" not in page_of(over, State(False, 10))
    checked(page_of(overview_of([]), State(True, 10)))


def test_the_page_keeps_its_size() -> None:
    rows = (
        row(n, robot=f"r{n % 999}", status="crashed" if n % 2 else "done", reason="x", site=f"s{n}")
        for n in range(20_000)
    )
    page = page_of(overview_of(rows), State(False, 0))
    assert len(page) < 300_000
    assert "9,800 more are in the table" in page


# ---- merging


def test_runs_of_two_machines_become_one(fleet: Fleet, tmp_path: Path) -> None:
    fleet.log("a")
    fleet.log("b", "kill")
    manifest = fleet.manifest_of_all()
    fleet.run(manifest, "--retries", "0")
    first = fleet.out
    fleet.out = tmp_path / "second"
    (fleet.folder / "logs" / "b").write_text("ok\nb")
    fleet.run(manifest)
    both = tmp_path / "both"
    assert main(["merge", str(first), str(fleet.out), "-o", str(both)]) == 0
    table = parquet.read_table(both / "fleet.parquet").to_pydict()
    assert sorted(table["log"]) == [str(fleet.folder / "logs" / name) for name in "ab"]
    assert set(table["status"]) == {"done"}
    for result in table["result"]:
        assert (both / result / "summary.json").exists()
    # Where only tables were brought along, they do.
    shutil.rmtree(fleet.out / "rows")
    assert main(["merge", str(first), str(fleet.out), "-o", str(both)]) == 0
    assert parquet.read_table(both / "fleet.parquet").num_rows == 2


def test_a_report_is_made_anew(fleet: Fleet, capsys: pytest.CaptureFixture[str]) -> None:
    fleet.log("a")
    fleet.run(fleet.manifest_of_all())
    (fleet.out / "fleet.html").unlink()
    (fleet.out / "fleet.parquet").unlink()
    assert main(["report", str(fleet.out)]) == 0
    assert (fleet.out / "fleet.html").exists() and (fleet.out / "fleet.parquet").exists()
    assert main(["report", str(fleet.folder / "logs")]) == 2
    assert "holds no results" in capsys.readouterr().err


def test_outputs_are_renewed_now_and_then() -> None:
    calls: list[int] = []
    renewal = Renewal(lambda: calls.append(1), every_s=0.0)
    renewal()
    assert len(calls) == 1
    never = Renewal(lambda: calls.append(1))
    never()
    assert len(calls) == 1


# ---- manifests of folders


def test_a_folder_is_listed(tmp_path: Path) -> None:
    for name in (
        "north/r1/a.bag",
        "north/r1/b.clf.gz",
        "north/r2/rec/rec_0.db3",
        "north/r2/rec/metadata.yaml",
        "south/r3/ucsd/Hokuyo20.npz",
        "south/r3/ucsd/Hokuyo21.npz",
        "south/r3/one/Hokuyo5.npz",
        "south/readme.txt",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    text = io.StringIO()
    assert write_listing(str(tmp_path), ["site", "robot"], text) == 6
    lines = [line.replace(f"{tmp_path}/", "") for line in text.getvalue().splitlines()]
    assert lines == [
        "log,robot,site,options",
        "north/r1/a.bag,r1,north,",
        "north/r1/b.clf.gz,r1,north,",
        "north/r2/rec,r2,north,",
        "south/r3/one,r3,south,",
        "south/r3/ucsd#20,r3,south,",
        "south/r3/ucsd#21,r3,south,",
    ]


# ---- progress


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_progress_on_a_terminal_renews_its_line() -> None:
    stream = Terminal()
    progress = Progress(10, stream)
    progress.skipped, progress.done, progress.failed = 2, 3, 1
    progress.tell(2, at_once=True)
    progress.tell(2)
    progress.say("a sentence")
    assert stream.getvalue().startswith("\r\x1b[K6 of 10 logs: 3 done, 1 failed, 2 as before; 2 ru")
    assert stream.getvalue().endswith("\r\x1b[Ka sentence\n")
    assert stream.getvalue().count("6 of 10") == 1


def test_progress_elsewhere_is_lines_now_and_then() -> None:
    stream = io.StringIO()
    progress = Progress(10, stream)
    progress.tell(1)
    assert stream.getvalue() == ""
    progress.tell(1, at_once=True)
    assert stream.getvalue() == "0 of 10 logs: 0 done, 0 failed; 1 running\n"
    progress.done = 4
    assert progress.line(1, 20.0).endswith("; 30 s left")


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.5, "0.5 s"), (40, "40 s"), (600, "10 min"), (9000, "2.5 h"), (1e6, "12 d")],
)
def test_durations(seconds: float, text: str) -> None:
    assert duration_text(seconds) == text


# ---- the command line


@pytest.mark.parametrize(
    ("flags", "told"),
    [
        (["--shard", "2/2"], "from 0 to n - 1"),
        (["--again", "broken"], "is no status"),
        (["--address", "x:1"], "--executor dask or ray"),
        (["--program", "/no/such/program"], "no such program"),
        (["--robots", "/no/such"], "no such folder"),
        (["--max-memory", "1M"], "at least 16M"),
        (["--", "--robot", "x.toml"], "--robots FOLDER"),
        (["--", "--threads=2"], "gives it by itself"),
    ],
)
def test_wrong_calls_are_told(
    fleet: Fleet, capsys: pytest.CaptureFixture[str], flags: list[str], told: str
) -> None:
    fleet.log("a")
    assert fleet.run(fleet.manifest_of_all(), *flags) == 2
    said = capsys.readouterr().err
    assert told in said and said.startswith("loopstone-fleet: ")
    assert not fleet.out.exists()


def test_results_go_to_a_folder(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "x.csv", "-o", "s3://bucket/out"]) == 2
    assert "results go to a folder" in capsys.readouterr().err


def test_the_version_is_loopstones() -> None:
    header = (ROOT / "include/loopstone/version.hpp").read_text()
    assert f'kVersion = "{__version__}"' in header


def test_flat_keeps_what_is_flat() -> None:
    once = flat(row(1, faults=[1, 2]))
    assert flat(once) == once
