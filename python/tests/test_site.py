"""Sites: what the package makes of them is what `loopstone site` makes of them."""

from __future__ import annotations

import datetime
import json
import shutil
import sqlite3
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loopstone as ls
from loopstone.options import MapOptions

# Files that tell how long a run took, or by which command it was made.
OF_THE_RUN = {"summary.json", "report.html"}
UTC = datetime.timezone.utc


def hall(*, with_shelf: bool) -> ls.GridMap:
    """A room of 9 m x 7 m that is like itself from one side only."""
    cells = np.full((160, 200), -1, np.int8)
    cells[10:150, 10:190] = 0
    for rows, columns in [
        (slice(8, 12), slice(8, 192)),
        (slice(148, 152), slice(8, 192)),
        (slice(8, 152), slice(8, 12)),
        (slice(8, 152), slice(188, 192)),
        (slice(8, 60), slice(120, 126)),
        (slice(110, 122), slice(12, 50)),
        (slice(128, 152), slice(140, 152)),
        (slice(60, 66), slice(30, 36)),
    ]:
        cells[rows, columns] = 100
    if with_shelf:
        cells[84:100, 160:176] = 100
    return ls.GridMap(cells, 0.05, [0.0, 0.0])


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Of four days, after the second of which a shelf is put up; and of another building."""
    folder = tmp_path_factory.mktemp("days")
    worlds: list[Any] = [hall(with_shelf=False)] * 2 + [hall(with_shelf=True)] * 2 + ["rooms"]
    paths = [folder / f"day_{day}.mcap" for day in range(1, 6)]
    for day, (world, path) in enumerate(zip(worlds, paths), 1):
        drive = ls.simulate(world, seed=day, duration_s=30.0, laser__beams=181, laser__rate_hz=5.0)
        drive.save(path, "mcap")
    return paths


def date_of(log: Path) -> str:
    return f"2026-11-0{log.stem[-1]}"


def site_of(path: Path, logs: list[Path]) -> ls.Site:
    site = ls.Site(path)
    for log in logs:
        site.add(log, date=date_of(log))
    return site


@pytest.fixture(scope="module")
def site(logs: list[Path], tmp_path_factory: pytest.TempPathFactory) -> ls.Site:
    """Nothing changes it."""
    return site_of(tmp_path_factory.mktemp("site") / "hall.site", logs)


@pytest.fixture
def copy(site: ls.Site, tmp_path: Path) -> ls.Site:
    """Of which the tests may do what they like."""
    shutil.copy(site, tmp_path / "copy.site")
    return ls.Site(tmp_path / "copy.site", create=False)


@pytest.fixture(scope="module")
def today(site: ls.Site) -> ls.SiteMap:
    return site.map(keep_scans=True)


def test_sessions_are_those_of_the_program(
    site: ls.Site, logs: list[Path], tmp_path: Path, run: Any
) -> None:
    theirs = tmp_path / "theirs.site"
    for log in logs:
        run("site", "add", theirs, log, "--date", date_of(log), "--quiet")
    shown = json.loads(run("site", "show", theirs, "--ties", "--json").stdout)
    assert [s.status for s in site.sessions] == ["joined"] * 4 + ["pending"]
    for ours, row in zip(site.sessions, shown["sessions"], strict=True):
        assert ours.begins == datetime.datetime.fromisoformat(row["begins"][:-1] + "+00:00")
        assert ours.begins_ns == ours.begins.timestamp() * 1e9
        assert abs(datetime.datetime.now(UTC) - ours.added) < datetime.timedelta(minutes=5)
        assert ours.robot.to_toml()
        for key in set(row) - {"begins", "added"}:
            assert getattr(ours, key) == row[key], key
    for tie, row in zip(site.ties, shown["ties"], strict=True):
        assert (tie.older, tie.newer) == (row["older"], row["newer"])
        told = Counter(c.state + (f": {c.reason}" if c.reason else "") for c in tie.closures)
        assert told == row["closures"]
    assert site.options_toml == ls.Site(theirs).options_toml
    events = json.loads(run("site", "history", theirs, "--json").stdout)["events"]
    assert [(e.what, e.log, e.text) for e in site.history] == [
        (e["what"], e["log"], e["text"]) for e in events
    ]
    # The file itself, but for when it was written.
    np.testing.assert_array_equal(
        site.map().trajectory.poses, ls.Site(theirs).map().trajectory.poses
    )


def test_files_of_the_map_are_those_of_the_program(
    site: ls.Site, today: ls.SiteMap, tmp_path: Path, run: Any
) -> None:
    ours, theirs = tmp_path / "ours", tmp_path / "theirs"
    today.save(ours)
    run("site", "map", site.path, "-o", theirs, "--quiet")
    names = sorted(path.name for path in theirs.iterdir())
    assert sorted(path.name for path in ours.iterdir()) == names
    assert {"map.pgm", "movable.pgm", "trajectory_drive_4.tum"} <= set(names)
    for name in set(names) - OF_THE_RUN:
        assert (ours / name).read_bytes() == (theirs / name).read_bytes(), name
    summary = json.loads((theirs / "summary.json").read_text())
    assert set(today.summary) == set(summary) - {"result_of"}
    for key in ("scans", "drives", "map_area_m2", "quality"):
        assert today.summary[key] == summary[key], key
    with pytest.raises(ls.UsageError, match="holds files already"):
        today.save(ours)


def test_the_parts_of_a_map_fit_together(site: ls.Site, today: ls.SiteMap) -> None:
    assert isinstance(today, ls.MapResult) and today.map is not None
    assert [s.id for s in today.sessions] == [s.id for s in site.sessions if s.status == "joined"]
    assert [len(path) for path in today.trajectories] == [s.scans for s in today.sessions]
    assert sum(len(path) for path in today.trajectories) == len(today.trajectory)
    assert today.movable.shape == today.map.shape and today.movable.dtype == np.float32
    assert 0.0 <= today.movable.min() and today.movable.max() <= 1.0
    assert not today.movable.flags.writeable
    one, other = today.movable, today.movable
    assert np.shares_memory(one, other)
    assert today.has_scans and not site.map("2026-11-02").has_scans
    assert today.drives == 4 and today.verdict.overall and "4 sessions" in repr(today)
    shown: Any = today
    assert "base64" in shown._repr_html_()


def test_a_view_outlives_its_map(site: ls.Site) -> None:
    made = site.map()
    view, before = made.movable, made.movable.copy()
    del made
    np.testing.assert_array_equal(view, before)


def test_the_building_as_it_was(site: ls.Site, tmp_path: Path, run: Any) -> None:
    before = site.map(datetime.date(2026, 11, 2))
    before.save(tmp_path / "ours")
    run("site", "map", site.path, "-o", tmp_path / "theirs", "--date", "2026-11-02", "--quiet")
    for name in ("map.pgm", "movable.pgm"):
        theirs = (tmp_path / "theirs" / name).read_bytes()
        assert (tmp_path / "ours" / name).read_bytes() == theirs
    assert before.map is not None
    for same in ("2026-11-02T23:59", datetime.datetime(2026, 11, 2, 12)):
        made = site.map(same)
        assert made.map is not None
        np.testing.assert_array_equal(made.map.log_odds, before.map.log_odds)


def test_changes_are_those_of_the_program(site: ls.Site, tmp_path: Path, run: Any) -> None:
    changes = site.changes("2026-11-02", "2026-11-04")
    changes.save(tmp_path / "ours")
    words = ["--from", "2026-11-02", "--to", "2026-11-04", "-o", tmp_path / "theirs", "--json"]
    rows = json.loads(run("site", "changes", site.path, *words).stdout)["changes"]
    for name in ("changes.csv", "changes.png"):
        theirs = (tmp_path / "theirs" / name).read_bytes()
        assert (tmp_path / "ours" / name).read_bytes() == theirs, name
    # The shelf, and nothing else.
    (change,) = changes
    assert len(changes) == len(rows) == 1 and changes[0].appeared and changes[-1].appeared
    assert rows[0] == {
        "appeared": change.appeared,
        "x_m": [change.low[0], change.high[0]],
        "y_m": [change.low[1], change.high[1]],
        "area_m2": change.area_m2,
    }
    np.testing.assert_allclose(change.high - change.low, 0.8, atol=0.25)
    np.testing.assert_array_equal(changes.boxes, [[*change.low, *change.high]])
    np.testing.assert_array_equal(changes.areas_m2, [change.area_m2])
    assert changes.now.map is not None and changes.before.shape == changes.now.map.shape
    with pytest.raises(IndexError):
        changes[1]
    with pytest.raises(ls.UsageError, match="holds files already"):
        changes.save(tmp_path / "ours")
    assert len(site.changes("2026-11-01", "2026-11-02")) == 0


def test_the_order_of_adding_changes_nothing(
    site: ls.Site, logs: list[Path], tmp_path: Path
) -> None:
    other = site_of(tmp_path / "other.site", [logs[2], logs[0], logs[1]])
    whole = site_of(tmp_path / "whole.site", logs[:3])
    assert [s.log for s in other.sessions] == [s.log for s in whole.sessions]
    np.testing.assert_array_equal(other.map().trajectory.poses, whole.map().trajectory.poses)


def test_a_site_is_a_map_to_localise_on(
    site: ls.Site, today: ls.SiteMap, logs: list[Path], tmp_path: Path, run: Any
) -> None:
    out = tmp_path / "where.tum"
    words = ["--seed", "5", "--start", "0", "--max-scans", "60", "-o", out, "--quiet", "--global"]
    run("localize", logs[3], "--map", site.path, *words)
    for given in (site, site.path, Path(site), today):
        made = ls.localize(logs[3], given, seed=5, max_scans=60)
        assert made.trajectory.to_tum() == out.read_text()
    scan = next(m for m in ls.open_log(logs[3]) if isinstance(m, ls.LaserScan))
    assert ls.relocalize(scan, site).candidates[0].probability > 0.5
    assert ls.Localizer(site).particles.shape[1] == 3


def test_errors_are_those_of_the_program(
    copy: ls.Site, logs: list[Path], tmp_path: Path, run: Any
) -> None:
    none = tmp_path / "none.site"
    with pytest.raises(ls.MissingFileError) as missing:
        ls.Site(none, create=False)
    assert str(missing.value) in run("site", "show", none, code=1).stderr
    assert not none.exists()
    (tmp_path / "text.site").write_text("x" * 4000)
    with pytest.raises(ls.DataError) as no_site:
        ls.Site(tmp_path / "text.site")
    assert str(no_site.value) in run("site", "show", tmp_path / "text.site", code=1).stderr
    with pytest.raises(ls.UsageError) as twice:
        copy.add(logs[0])
    assert str(twice.value) in run("site", "add", copy.path, logs[0], code=2).stderr
    with pytest.raises(ls.UsageError) as unknown:
        copy.prune([77])
    assert str(unknown.value) in run("site", "prune", copy.path, "--session", "77", code=2).stderr
    with pytest.raises(ls.DataError) as early:
        copy.map("1961-04-12")
    out = tmp_path / "out"
    words = ["--date", "1961-04-12", "-o", out]
    assert str(early.value) in run("site", "map", copy.path, *words, code=1).stderr
    with pytest.raises(ls.UsageError) as no_date:
        copy.add(logs[0], date="yesterday")
    words = ["--date", "yesterday"]
    assert str(no_date.value) in run("site", "add", copy.path, logs[0], *words, code=2).stderr
    with pytest.raises(ls.UsageError, match="until lies before since"):
        copy.changes("2026-11-03", "2026-11-02")
    with pytest.raises(TypeError, match="since: expected"):
        copy.changes(5)  # type: ignore[arg-type]
    with pytest.raises(ls.DataError, match="there is no session"):
        ls.Site(tmp_path / "new.site").map()
    assert len(copy.sessions) == 5


def test_a_damaged_site_says_what_is_lost(copy: ls.Site, run: Any) -> None:
    assert copy.check() == []
    with sqlite3.connect(copy) as database:
        database.execute("UPDATE records SET record = zeroblob(100) WHERE session = 2")
    database.close()
    problems = copy.check()
    told = run("site", "check", copy.path, "--json", code=1)
    assert problems == json.loads(told.stdout)["problems"] and "session 2" in problems[0]
    with pytest.raises(ls.DataError, match="is damaged"):
        copy.map()


def test_sessions_are_removed_as_by_the_program(copy: ls.Site, tmp_path: Path, run: Any) -> None:
    theirs = tmp_path / "theirs.site"
    shutil.copy(copy, theirs)
    removed = copy.prune([copy.sessions[1]], pending=True)
    words = ["--session", "2", "--pending", "--json"]
    told = json.loads(run("site", "prune", theirs, *words).stdout)
    assert removed.removed == told["removed"] == 2
    assert removed.bytes < removed.bytes_before and removed.bytes == copy.bytes
    assert [s.id for s in copy.sessions] == [1, 3, 4]
    assert copy.history[-1].what == "remove" and copy.history[-1].at.tzinfo is UTC
    before = copy.map().trajectory.poses
    np.testing.assert_array_equal(before, ls.Site(theirs).map().trajectory.poses)
    assert [s.status for s in copy.rebuild()] == ["joined"] * 3
    np.testing.assert_array_equal(before, copy.map().trajectory.poses)


def test_it_is_corrected_as_by_the_program(copy: ls.Site, tmp_path: Path, run: Any) -> None:
    theirs = tmp_path / "theirs.site"
    shutil.copy(copy, theirs)
    wall = copy.set_cells("wall", [(-0.4, -0.4), (0.4, -0.4), (0.4, 0.4), (-0.4, 0.4)])
    run("site", "edit", theirs, "--wall", "-0.4,-0.4 0.4,-0.4 0.4,0.4 -0.4,0.4")
    left_out = copy.exclude(copy.sessions[1])
    run("site", "edit", theirs, "--exclude", "2")
    assert (wall.id, wall.kind, wall.session) == (1, "wall", None)
    assert (left_out.kind, left_out.session, left_out.polygon) == ("exclude", 2, None)
    assert wall.at.tzinfo is UTC and copy.history[-1].what == "exclude"
    assert copy.sessions[1].status == "excluded" and "edit 2" in copy.sessions[1].reason
    told = json.loads(run("site", "edits", theirs, "--json").stdout)["edits"]
    assert [edit.kind for edit in copy.edits] == [edit["kind"] for edit in told]
    assert wall.polygon is not None and wall.polygon.tolist() == told[0]["polygon"]

    made = copy.map()
    assert made.map is not None
    column, row = ((np.array([0.1, 0.1]) - made.map.origin) / made.map.resolution_m).astype(int)
    assert made.map.probability[row, column] > 0.9
    assert [edit.id for edit in made.edits] == [1, 2]
    made.record(tmp_path / "ours.mcap")
    made.save(tmp_path / "ours")
    words = ["-o", tmp_path / "theirs", "--mcap", tmp_path / "theirs.mcap"]
    run("site", "map", theirs, *words)
    for name in ["ours", "ours.mcap"]:
        assert (tmp_path / name).exists()
    for name in ["map.pgm", "sessions.csv", "movable.pgm"]:
        ours = (tmp_path / "ours" / name).read_bytes()
        assert ours == (tmp_path / "theirs" / name).read_bytes(), name

    copy.undo(wall)
    copy.include(2)
    assert copy.edits == [] and copy.sessions[1].status == "joined"
    mistakes: list[Callable[[], object]] = [
        lambda: copy.undo(9),
        lambda: copy.include(2),
        lambda: copy.exclude(77),
        lambda: copy.set_cells("wall", [(0.0, 0.0), (1.0, 0.0)]),
        lambda: copy.set_cells("wall", [0.0, 1.0]),
        lambda: copy.set_cells("door", wall.polygon),  # type: ignore[arg-type]
    ]
    for wrong in mistakes:
        with pytest.raises(ls.UsageError):
            wrong()


def test_a_site_keeps_its_options(logs: list[Path], tmp_path: Path, run: Any) -> None:
    coarse = ls.Site(tmp_path / "coarse.site", map__resolution_m=0.1)
    run("site", "add", tmp_path / "theirs.site", logs[0], "--set", "map.resolution_m=0.1")
    assert coarse.options_toml == ls.Site(tmp_path / "theirs.site").options_toml
    options = MapOptions()
    options.map.resolution_m = 0.1
    again = ls.Site(coarse, options=options)
    again.add(logs[0], max_scans=60)
    assert again.sessions[0].scans == 60
    made = again.map()
    assert made.map is not None and made.map.resolution_m == 0.1
    with pytest.raises(ls.UsageError, match="made otherwise.*resolution_m"):
        ls.Site(coarse, options=MapOptions())
    with pytest.raises(ls.OptionsError, match="map.resolution_m"):
        ls.Site(tmp_path / "bad.site", map__resolution_m=7.0)
    assert not (tmp_path / "bad.site").exists()


def test_progress_is_told_and_may_end_the_call(
    site: ls.Site, logs: list[Path], tmp_path: Path
) -> None:
    told: set[str] = set()
    new = ls.Site(tmp_path / "new.site")

    def note(progress: ls.Progress) -> None:
        told.add(progress.step)

    new.add(logs[0], progress=note)
    assert "mapping" in told

    class Enough(Exception):
        pass

    def stop(progress: ls.Progress) -> None:
        raise Enough

    with pytest.raises(Enough):
        new.add(logs[1], progress=stop)
    assert new.check() == [] and len(new.sessions) == 1
    with pytest.raises(Enough):
        site.map(progress=stop)


# Locks of files are a process's: another SQLite in this one would not see them.
WRITER = """
import sqlite3, sys
site = sqlite3.connect(sys.argv[1], isolation_level=None)
site.execute("BEGIN IMMEDIATE")
print("writes", flush=True)
sys.stdin.read()
"""


def test_who_writes_waits_for_who_does(copy: ls.Site) -> None:
    other = subprocess.Popen(
        [sys.executable, "-c", WRITER, copy],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert other.stdout is not None and other.stdout.readline() == "writes\n"
    waits = threading.Event()

    def note(progress: ls.Progress) -> None:
        if progress.step.startswith("waiting"):
            waits.set()

    thread = threading.Thread(target=lambda: copy.prune([5], progress=note))
    thread.start()
    assert waits.wait(timeout=60.0)
    assert len(copy.sessions) == 5  # readers don't wait
    other.communicate()
    thread.join()
    assert len(copy.sessions) == 4
