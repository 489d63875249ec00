#!/usr/bin/env python3
"""The measuring scripts of bench/ are held to the truth where that is known: tests/bench/check_bench.py"""
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "bench")]

import program  # noqa: E402

MB = 1_000_000


def takes(megabytes):
    """A command that holds so much at its peak."""
    return [sys.executable, "-I", "-S", "-c", f"block = b'x' * {megabytes * MB}"]


def check_peak_memory():
    """Of the child, neither of a parent with much memory nor of a child before."""
    _, large = program.run(takes(150))
    assert 150 < large["peak_mb"] < 175, large
    block = b"x" * (400 * MB)
    for megabytes in (1, 60):
        _, cost = program.run(takes(megabytes))
        assert megabytes < cost["peak_mb"] < megabytes + 25, cost
    assert len(block) == 400 * MB


def check_run():
    """Output, time, errors and exit codes arrive through the launcher."""
    output, cost = program.run(["sh", "-c", "echo heard; echo noise >&2; sleep 0.2"])
    assert output == "heard\n" and 0.2 <= cost["wall_s"] < 2.0 and cost["cpu_s"] < 0.2, (output, cost)
    for command, said in [(["sh", "-c", "echo why >&2; exit 3"], "ended with 3\nwhy\n"),
                          (["sh", "-c", "kill -9 $$"], "ended with 137\n"),
                          (["/no/such/program"], "ended with 127\n/no/such/program: No such file")]:
        try:
            program.run(command)
        except program.Failed as failure:
            assert said in str(failure), failure
        else:
            raise AssertionError(f"{command} should have failed")
    assert program.run(["sh", "-c", "exit 3"], check=False)[0] == ""
    # More on stderr than a pipe holds.
    program.run(["sh", "-c", "head -c 300000 /dev/zero >&2; echo done"])


def main():
    check_peak_memory()
    check_run()


if __name__ == "__main__":
    main()
