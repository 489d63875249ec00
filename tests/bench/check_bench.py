#!/usr/bin/env python3
"""The measuring scripts of bench/ are held to the truth where that is known:
tests/bench/check_bench.py"""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "bench")]

import compare_speed  # noqa: E402
import drives  # noqa: E402
import drives_tables  # noqa: E402
import program  # noqa: E402
import provenance  # noqa: E402
import skipped_tests  # noqa: E402
import unkind  # noqa: E402

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
    assert output == "heard\n" and 0.2 <= cost["wall_s"] < 2.0 and cost["cpu_s"] < 0.2, (
        output,
        cost,
    )
    for command, said in [
        (["sh", "-c", "echo why >&2; exit 3"], "ended with 3\nwhy\n"),
        (["sh", "-c", "kill -9 $$"], "ended with 137\n"),
        (["/no/such/program"], "ended with 127\n/no/such/program: No such file"),
    ]:
        try:
            program.run(command)
        except program.Failed as failure:
            assert said in str(failure), failure
        else:
            raise AssertionError(f"{command} should have failed")
    assert program.run(["sh", "-c", "exit 3"], check=False)[0] == ""
    # More on stderr than a pipe holds.
    program.run(["sh", "-c", "head -c 300000 /dev/zero >&2; echo done"])


def check_scripts_load():
    """Whatever `make bench` runs finds its modules and tells what it does; without numpy one
    can't."""
    makers = (ROOT / "bench/figures.sh").read_text(encoding="utf-8")
    scripts = re.findall(r"^ *measure (\S+\.py)", makers, re.M)
    assert len(scripts) > 12, scripts
    for script in scripts:
        done = subprocess.run(
            [sys.executable, ROOT / script, "--help"],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
        )
        assert (
            done.returncode == 0 and b"usage: " in done.stdout or b"needs numpy" in done.stdout
        ), (script, done.stdout.decode())


def check_provenance():
    """A stamp of this very tree can be read back, and tells a tree that is not as its commit has
    it."""
    with tempfile.TemporaryDirectory() as folder:
        for words in (
            ["init", "-q"],
            [
                "-c",
                "user.name=a",
                "-c",
                "user.email=a@b",
                "commit",
                "-q",
                "--allow-empty",
                "-m",
                "first",
            ],
        ):
            if provenance.git(*words, root=folder) is None:
                print("skipped: stamps of tables, since there is no git")
                return
        assert provenance.changed_sources(folder) == []
        (pathlib.Path(folder) / "src").mkdir()
        (pathlib.Path(folder) / "src/new.cpp").touch()
        (pathlib.Path(folder) / "docs.md").touch()
        assert provenance.changed_sources(folder) == ["src/"], provenance.changed_sources(folder)
    section = {
        **provenance.circumstances("loopstone 1.2.3"),
        "commit": "0123456789",
        "changed": ["src/"],
    }
    section["machine"]["load"] = 0.0
    text = provenance.provenance(section)
    assert "commit 0123456789 with changes in src/, 20" in text, text
    assert provenance.stamps_of(text) == [
        (section["command"].split()[0], "1.2.3", "0123456789")
    ], text
    assert provenance.provenance(section, section) == text and text in provenance.provenance(
        section, {**section, "date": "2026-01-01"}
    )
    assert (
        provenance.command_line([str(ROOT / "bench/figures.py"), "--only", "real logs"])
        == "bench/figures.py --only 'real logs'"
    )


def check_skipped_tests():
    """Each test once, by reason; those without recorded data together."""
    lines = [
        "test_a\tS.Two\trecorded data is absent: x",
        "test_a\tS.One\t/data/y is not here",
        "test_b\tT.Long\tneeds whole laps",
        "test_a\tS.One\t/data/y is not here",
    ]
    assert list(skipped_tests.lines_of("\n".join(lines))) == [
        "1 test skipped, needs whole laps: test_b T.Long",
        "2 tests skipped, they need recorded data (LOOPSTONE_DATA): test_a S.One, S.Two",
    ]


def check_comparison():
    """Slower is what nearly every pair says; one busy moment, or a little, is not."""
    base = [1.0, 1.1, 0.9, 1.0, 1.05, 1.0, 0.95, 1.0, 1.0]
    assert compare_speed.judge(base, [1.4 * seconds for seconds in base])[3]
    assert not compare_speed.judge(base, [1.2 * seconds for seconds in base])[3]
    assert not compare_speed.judge(base, [*base[:5], 9.0, 9.0, 9.0, 9.0])[3]
    assert not compare_speed.judge(base, [0.5 * seconds for seconds in base])[3]


def check_drives():
    """Every spoil as often, with each robot too; a part of the drives is the same drives."""
    whole = argparse.Namespace(
        drives=None, worlds=drives.WORLDS, robots=list(unkind.ROBOTS), effects=None
    )
    whole.seeds, whole.first_seed = drives.DRIVES, drives.FIRST_SEED
    all_drives = drives.drives_of(whole)
    assert len(all_drives) == len({drive.seed for drive in all_drives}) == 200
    spoils = [(drive.robot, drive.effect) for drive in all_drives if drive.effect != unkind.USUAL]
    assert len(set(spoils)) == len(unkind.ROBOTS) * len(drives.SPOILS)
    assert {spoils.count(each) for each in spoils} == {3}
    part = argparse.Namespace(**{**vars(whole), "worlds": ["hall"], "robots": ["small"]})
    assert len(drives.drives_of(part)) == 5 and set(drives.drives_of(part)) < set(all_drives)
    part.drives = [all_drives[-1].key()]
    assert drives.drives_of(part) == [all_drives[-1]]


def check_drives_tables():
    """What is counted of three drives: one right, one wrong and called good, one not mapped."""
    right = {"ate_m": 0.3, "worst_m": 0.4, "worst_deg": 0.9, "verdict": "doubtful"}
    right |= {"closures": {"accepted": 3, "false": 0, "revisits": 4, "recognised": 3}}
    right |= {"without": {"ate_m": 0.2, "worst_m": 0.3, "worst_deg": 0.9}}
    wrong = {"ate_m": 0.1, "worst_m": 0.2, "worst_deg": 1.1, "verdict": "good"}
    wrong |= {"closures": {"accepted": 1, "false": 1, "revisits": 0, "recognised": 0}}
    wrong["closures"] |= {"false_m": 2.0, "false_deg": 3.0}
    found = [right, wrong, {"failed": ["why"]}, {"ate_m": 0.05}]
    figures = {}
    for seed, effect in [(1, "usual"), (2, "usual"), (3, "usual"), (1, unkind.CLEAN)]:
        drive = unkind.Drive("gyro", "office", effect, seed)
        figures[drive.key()] = {**drive._asdict(), **found.pop(0)}
    runs = drives_tables.join_clean(figures)
    assert [measured for _, _, measured, _ in drives_tables.targets_of(runs)] == [
        "1",
        "1 of 1",
        "75.00 %",
        "1 of 1",
    ], drives_tables.targets_of(runs)
    row = drives_tables.row_of("all", runs)
    assert row[1:7] == ["3", "1", "0", "2", "1", "5.0"] and row[-4:] == ["4", "1", "4", "75.0 %"]
    assert [list(drives_tables.faults_of(run)) for run in runs] == [
        ["ATE 0.30 m, without closing loops 0.20 m"],
        ["wrong and called good", "false loop closures: 1, up to 2.00 m, 3.0 deg off"],
        ["not mapped"],
    ]


def main():
    check_drives()
    check_drives_tables()
    check_skipped_tests()
    check_comparison()
    check_peak_memory()
    check_scripts_load()
    check_provenance()
    check_run()


if __name__ == "__main__":
    main()
