"""Runs on this machine: results by content, rows once, faults by their names."""

from __future__ import annotations

import importlib.util
import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pyarrow.parquet as parquet
import pytest

from conftest import Fleet, simulate
from loopstone_fleet.main import main
from loopstone_fleet.result_store import ResultStore


def test_maps_real_logs_to_rows_table_and_page(real_fleet: Fleet) -> None:
    fleet = real_fleet
    for seed in (1, 2):
        simulate(fleet, f"{seed}.clf", seed)
    (fleet.folder / "logs" / "junk.clf").write_text("junk\n")
    lines = [
        f"logs/{name}.clf,robot{name},{cell}"
        for name, cell in [(1, ""), (2, "match.max_iterations=9"), ("junk", "")]
    ]
    assert fleet.run(fleet.manifest(lines, "log,robot,options"), "--max-memory", "1G") == 0
    rows = fleet.rows()
    assert fleet.statuses() == {"1.clf": "done", "2.clf": "done", "junk.clf": "bad_data"}
    assert "holds no line of a CARMEN log" in rows["junk.clf"]["reason"]
    first = fleet.out / rows["1.clf"]["result"]
    summary = json.loads((first / "summary.json").read_text())
    assert rows["1.clf"]["quality"] == summary["quality"]
    assert rows["1.clf"]["scans"] == summary["scans"] > 50
    assert (
        "max_iterations = 9" in (fleet.out / rows["2.clf"]["result"] / "options.toml").read_text()
    )
    assert rows["1.clf"]["process_peak_memory_bytes"] > 5e6
    assert rows["1.clf"]["process_cpu_s"] > 0
    stamp = float((first / "trajectory.tum").read_text().split()[0])
    assert rows["1.clf"]["starts_at_s"] == stamp
    table = parquet.read_table(fleet.out / "fleet.parquet").to_pydict()
    assert sorted(Path(log).name for log in table["log"]) == ["1.clf", "2.clf", "junk.clf"]
    assert sorted(table["scans"], key=str)[:2] == [rows["1.clf"]["scans"], rows["2.clf"]["scans"]]
    page = (fleet.out / "fleet.html").read_text()
    assert f"{rows['1.clf']['result']}/report.html" in page
    assert list((fleet.out / "work").iterdir()) == []


def test_what_is_done_is_skipped(fleet: Fleet) -> None:
    fleet.log("a")
    fleet.log("b", "bad")
    manifest = fleet.manifest_of_all()
    assert fleet.run(manifest) == 0
    before = fleet.rows()
    assert fleet.run(manifest) == 0
    assert fleet.rows() == before
    assert fleet.times_mapped("a") == fleet.times_mapped("b") == 1


def test_what_has_changed_is_done_again(fleet: Fleet, monkeypatch: pytest.MonkeyPatch) -> None:
    log = fleet.log("a")
    manifest = fleet.manifest_of_all()
    fleet.run(manifest)
    results = {fleet.rows()["a"]["result"]}
    log.write_text("ok\nanother drive\n")
    fleet.run(manifest)
    results.add(fleet.rows()["a"]["result"])
    monkeypatch.setenv("FAKE_VERSION", "10.0.0")
    fleet.run(manifest)
    results.add(fleet.rows()["a"]["result"])
    fleet.run(manifest, "--", "--no-texture")
    results.add(fleet.rows()["a"]["result"])
    assert fleet.times_mapped("a") == len(results) == 4


def test_equal_content_is_mapped_once(fleet: Fleet) -> None:
    first, second = fleet.log("a"), fleet.folder / "logs" / "b"
    manifest = fleet.manifest([str(first)])
    fleet.run(manifest)
    second.write_bytes(first.read_bytes())
    fleet.run(fleet.manifest_of_all())
    rows = fleet.rows()
    assert rows["a"]["result"] == rows["b"]["result"]
    assert (rows["a"]["reused"], rows["b"]["reused"]) == (False, True)
    assert fleet.times_mapped("a") + fleet.times_mapped("b") == 1
    assert rows["b"]["scans"] == 100


def test_a_lost_or_damaged_result_is_made_again(fleet: Fleet) -> None:
    fleet.log("a")
    manifest = fleet.manifest_of_all()
    fleet.run(manifest)
    summary = fleet.out / fleet.rows()["a"]["result"] / "summary.json"
    summary.unlink()
    fleet.run(manifest)
    assert fleet.times_mapped("a") == 2
    assert summary.exists()


def test_what_is_done_is_made_again_when_asked(fleet: Fleet) -> None:
    fleet.log("a")
    manifest = fleet.manifest_of_all()
    fleet.run(manifest)
    mark = fleet.out / fleet.rows()["a"]["result"] / "mark"
    mark.touch()
    assert fleet.run(manifest, "--again", "all") == 0
    assert fleet.times_mapped("a") == 2
    assert mark.parent.is_dir() and not mark.exists()
    assert list((fleet.out / "work").iterdir()) == []


def test_labels_change_without_work(fleet: Fleet) -> None:
    log = fleet.log("a")
    fleet.run(fleet.manifest([f"{log},r1"], "log,robot"))
    fleet.run(fleet.manifest([f"{log},r2"], "log,robot"))
    assert fleet.rows()["a"]["robot"] == "r2"
    assert fleet.times_mapped("a") == 1


def test_a_robots_file_is_part_of_the_recipe(fleet: Fleet) -> None:
    log = fleet.log("a")
    robots = fleet.folder / "robots"
    robots.mkdir()
    (robots / "r1.toml").write_text("name = 'r1'\n")
    manifest = fleet.manifest([f"{log},r1"], "log,robot")
    for text in ("", "", "odometry_scale = 1.1\n"):
        (robots / "r1.toml").open("a").write(text)
        assert fleet.run(manifest, "--robots", str(robots)) == 0
    assert fleet.times_mapped("a") == 2


def test_each_fault_has_its_status_and_its_one_row(fleet: Fleet) -> None:
    words = {
        "ok": "done",
        "bad": "bad_data",
        "exit 2": "bad_call",
        "exit 7": "crashed",
        "crash": "crashed",
        "lie": "crashed",
        "hang": "timeout",
        "eat": "out_of_memory",
        "gulp": "out_of_memory",
        "chatter": "crashed",
        "kill": "killed",
        "full": "disk_full",
        "once kill": "done",
        "once full": "done",
    }
    for word in words:
        fleet.log(word.replace(" ", "_"), word)
    manifest = fleet.manifest(
        [*(str(path) for path in sorted((fleet.folder / "logs").iterdir())), "logs/gone"]
    )
    flags = ["--timeout", "4", "--max-memory", "64M", "--retries", "1", "--workers", "4"]
    assert fleet.run(manifest, *flags) == 1
    expected = {word.replace(" ", "_"): status for word, status in words.items()}
    assert fleet.statuses() == {**expected, "gone": "bad_data"}
    rows = fleet.rows()
    assert rows["crash"]["reason"] == "signal 11; it last said: warning: about to go"
    assert "no such log" in rows["gone"]["reason"]
    assert 60e6 < rows["eat"]["process_peak_memory_bytes"] < 400e6
    # What is cured is tried again, what is not is not.
    attempts = {name: row["attempts"] for name, row in rows.items()}
    assert {name for name, count in attempts.items() if count == 2} == {
        "kill",
        "full",
        "once_kill",
        "once_full",
    }
    assert fleet.times_mapped("crash") == fleet.times_mapped("hang") == 1
    table = parquet.read_table(fleet.out / "fleet.parquet").to_pydict()
    assert len(table["log"]) == len(set(table["log"])) == len(words) + 1
    assert list((fleet.out / "work").iterdir()) == []


def test_curable_ends_and_higher_limits_are_tried_in_the_next_run(fleet: Fleet) -> None:
    fleet.log("killed", "kill")
    fleet.log("slow", "once hang")
    fleet.log("crash", "crash")
    manifest = fleet.manifest_of_all()
    assert fleet.run(manifest, "--timeout", "3", "--retries", "0") == 1
    assert fleet.statuses() == {"killed": "killed", "slow": "timeout", "crash": "crashed"}
    assert fleet.run(manifest, "--timeout", "2.9", "--retries", "0") == 1
    assert [fleet.times_mapped(name) for name in ("killed", "slow", "crash")] == [2, 1, 1]
    assert fleet.run(manifest, "--timeout", "30", "--retries", "0", "--again", "crashed") == 1
    assert [fleet.times_mapped(name) for name in ("killed", "slow", "crash")] == [3, 2, 2]
    assert fleet.statuses()["slow"] == "done"


def test_wrong_options_are_told_before_any_work(
    fleet: Fleet, capsys: pytest.CaptureFixture[str]
) -> None:
    manifest = fleet.manifest([f"{fleet.log('a')},", f"{fleet.log('b')},wrong=1"], "log,options")
    assert fleet.run(manifest) == 2
    assert f"{manifest}: line 3: options: wrong: unknown key" in capsys.readouterr().err
    assert fleet.times_mapped("a") == 0


def test_shards_cover_everything_once(fleet: Fleet) -> None:
    names = [f"log{number}" for number in range(9)]
    for name in names:
        fleet.log(name)
    manifest = fleet.manifest_of_all()
    for shard in ("0/2", "1/2"):
        assert fleet.run(manifest, "--shard", shard) == 0
    assert sorted(fleet.rows()) == names
    assert all(fleet.times_mapped(name) == 1 for name in names)
    counts = [
        parquet.read_table(fleet.out / f"fleet-{index}-of-2.parquet").num_rows for index in (0, 1)
    ]
    assert sum(counts) == 9 and min(counts) > 0
    assert main(["merge", str(fleet.out), "-o", str(fleet.out)]) == 0
    assert parquet.read_table(fleet.out / "fleet.parquet").num_rows == 9


def started(fleet: Fleet, manifest: Path, *flags: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "loopstone_fleet", "run", str(manifest), "-o", str(fleet.out)]
        + ["--program", str(fleet.program), "--workers", "2", *flags],
        stderr=subprocess.PIPE,
        start_new_session=True,
        env={**os.environ, "CALLS": str(fleet.calls)},
    )


def wait_for(fleet: Fleet, name: str) -> int:
    """The process of the fake program that has this log."""
    path = fleet.calls / name
    deadline = time.monotonic() + 60  # a cluster has to begin
    while time.monotonic() < deadline:
        if path.exists() and path.read_text().endswith("\n"):
            return int(path.read_text().split()[-1])
        time.sleep(0.02)
    raise AssertionError(f"{name} was never begun")


def is_gone(pid: int) -> bool:
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline:
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            return True
        if state == "Z":
            return True
        time.sleep(0.02)
    return False


@pytest.mark.parametrize(
    ("executor", "module", "number"),
    [
        ("local", "", signal.SIGINT),
        ("local", "", signal.SIGTERM),
        ("dask", "distributed", signal.SIGINT),
        ("ray", "ray", signal.SIGTERM),
    ],
)
def test_an_interrupt_ends_children_and_keeps_rows(
    fleet: Fleet, executor: str, module: str, number: int
) -> None:
    if module and importlib.util.find_spec(module) is None:
        pytest.skip(f"{module} is not installed")
    fleet.log("a_quick")
    fleet.log("b_hangs", "hang")
    fleet.log("c_next")
    fleet.log("d_hangs", "hang")
    fleet.log("e_never")
    process = started(
        fleet, fleet.manifest_of_all(), "--executor", executor, "--max-memory", "256M"
    )
    pids = [wait_for(fleet, name) for name in ("b_hangs", "d_hangs")]
    os.killpg(process.pid, number)  # as a terminal does
    _, said = process.communicate(timeout=30)
    assert process.returncode == 130, said
    assert all(is_gone(pid) for pid in pids)
    assert fleet.statuses() == {"a_quick": "done", "c_next": "done"}
    assert parquet.read_table(fleet.out / "fleet.parquet").num_rows == 2
    assert b"interrupted" in said and b"Traceback" not in said, said
    assert list((fleet.out / "work").iterdir()) == []


def test_work_of_processes_that_end_is_swept(tmp_path: Path) -> None:
    store = ResultStore(tmp_path)
    store.make()
    ended = subprocess.Popen(["true"])
    ending = subprocess.Popen(["sleep", "0.3"])
    living = subprocess.Popen(["sleep", "60"])
    folders = [
        tmp_path / "work" / f"{socket.gethostname()}-{process.pid}-abc"
        for process in (ended, ending, living)
    ]
    try:
        for folder in folders:
            folder.mkdir()
        assert is_gone(ended.pid)  # which nobody asked for its end yet
        store.sweep_work()
        assert [folder.exists() for folder in folders] == [False, True, True]
        store.sweep_work(patience_s=1.0)
        assert [folder.exists() for folder in folders] == [False, False, True]
    finally:
        living.kill()
        for process in (ended, ending, living):
            process.wait()


def test_a_killed_run_leaves_no_child_and_goes_on(fleet: Fleet) -> None:
    fleet.log("a_quick")
    hanging = fleet.log("b_hangs", "hang")
    process = started(fleet, fleet.manifest_of_all())
    pid = wait_for(fleet, "b_hangs")
    deadline = time.monotonic() + 20
    while fleet.statuses() != {"a_quick": "done"} and time.monotonic() < deadline:
        time.sleep(0.02)
    process.kill()
    process.communicate()
    assert is_gone(pid)
    assert len(list((fleet.out / "work").iterdir())) == 1
    hanging.write_text("ok\n")
    assert fleet.run(fleet.manifest_of_all()) == 0
    assert fleet.statuses() == {"a_quick": "done", "b_hangs": "done"}
    assert list((fleet.out / "work").iterdir()) == []
