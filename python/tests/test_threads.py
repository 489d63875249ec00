"""What else goes on while the library works: other threads, Ctrl-C, the end of the program."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import loopstone as ls


def test_other_threads_go_on_while_a_map_is_made(long_log: Path) -> None:
    done = threading.Event()
    counted = 0

    def count() -> None:
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    start = time.monotonic()
    ls.map(long_log, threads=1, duration_s=100.0)
    elapsed_ms = 1000.0 * (time.monotonic() - start)
    done.set()
    thread.join()
    # With the lock held it would count once or twice.
    assert counted > 20 and counted > elapsed_ms / 50.0


def test_maps_are_made_beside_one_another(log: Path, result: ls.MapResult) -> None:
    made: list[ls.MapResult] = []
    threads = [
        threading.Thread(target=lambda: made.append(ls.map(log, threads=1))) for _ in range(3)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for other in made:
        np.testing.assert_array_equal(other.trajectory.poses, result.trajectory.poses)


def test_one_mapper_may_be_asked_by_many_threads(drive: ls.Simulation) -> None:
    mapper = ls.Mapper(drive.robot)
    faults: list[BaseException] = []
    done = threading.Event()

    def look() -> None:
        try:
            while not done.is_set():
                mapper.live_map()
                mapper.key_poses
        except BaseException as error:
            faults.append(error)

    thread = threading.Thread(target=look)
    thread.start()
    for message in drive:
        mapper.add(message)
    done.set()
    thread.join()
    assert not faults
    mapper.finish()


CALLS = {
    "map": "ls.map(path)",
    "map_messages": "ls.map(messages)",
    "localize": "ls.localize(path, drive.map)",
    "summary": "[ls.open_log(path).summary() for _ in range(10**6)]",
    "iterate": "[m for _ in range(10**6) for m in ls.open_log(path)]",
    "calibrate": "ls.calibrate(path)",
    "convert": "[ls.convert(path, path + '.bag', force=True) for _ in range(10**6)]",
    "optimize": "ls.optimize(chain, certify=False, initial='file', solver__relative_tolerance=0.0)",
    "optimize_gnc": "ls.optimize(chain, robust='gnc', initial='file')",
    "certify": "ls.optimize(chain, initial='file')",
    "site_add": "ls.Site(path + '.site').add(path)",
    "simulate": "ls.simulate('campus', laser__rate_hz=100.0)",
}


@pytest.mark.parametrize("call", CALLS)
def test_ctrl_c_ends_a_call_at_once(call: str, long_log: Path, tmp_path: Path) -> None:
    """In a program of its own, which gets the signal half a second into the call."""
    script = textwrap.dedent(
        f"""
        import time, numpy as np, loopstone as ls

        def big_graph(n=60000):
            # Of which nothing is solved in half a second.
            rng = np.random.default_rng(1)
            poses = np.cumsum(rng.normal(size=(n, 3)), axis=0)
            edges = [(i, i + 1) for i in range(n - 1)]
            edges += [(i, i + 97) for i in range(0, n - 97, 3)]
            measured = rng.normal(size=(len(edges), 3))
            return ls.PoseGraph(poses, np.array(edges), measured, np.eye(3))

        path = {str(long_log)!r}
        drive = ls.simulate("office", duration_s=1.0)
        messages = list(ls.open_log(path)) * 3 if "messages" in {CALLS[call]!r} else []
        chain = big_graph() if "chain" in {CALLS[call]!r} else None
        print("begins", flush=True)
        try:
            {CALLS[call]}
            print("ended by itself", flush=True)
        except KeyboardInterrupt:
            print("interrupted", flush=True)
        """
    )
    command = [sys.executable, "-c", script]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == "begins\n"
        time.sleep(0.3)
        program.send_signal(signal.SIGINT)
        assert program.stdout.readline() == "interrupted\n"
        assert program.wait(timeout=20) == 0


def test_a_program_may_end_with_everything_open(log: Path) -> None:
    script = textwrap.dedent(
        f"""
        import loopstone as ls
        messages = iter(ls.open_log({str(log)!r}))
        mapper = ls.Mapper(messages.robot)
        for i, message in enumerate(messages):
            mapper.add(message)
            if i == 500:
                break
        result = ls.map({str(log)!r}, max_scans=20)
        view = result.map.log_odds
        """
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == ""  # nanobind tells of leaks


def test_spawned_processes_map(log: Path, result: ls.MapResult) -> None:
    script = textwrap.dedent(
        f"""
        import multiprocessing
        import loopstone as ls

        def length(scans):
            return ls.map({str(log)!r}, max_scans=scans).trajectory.path_length_m

        if __name__ == "__main__":
            ls.map({str(log)!r}, max_scans=10)
            with multiprocessing.get_context("spawn").Pool(2) as pool:
                print(pool.map(length, [30, 60]))
        """
    )
    path = log.parent / "spawn.py"
    path.write_text(script)
    done = subprocess.run(
        [sys.executable, path], capture_output=True, text=True, timeout=60, env=os.environ.copy()
    )
    assert done.returncode == 0, done.stderr
    short, long = eval(done.stdout)
    assert 0.0 <= short < long
