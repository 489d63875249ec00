#!/usr/bin/env python3
"""The measuring scripts of bench/ are held to the truth where that is known:
tests/bench/check_bench.py"""
import argparse
import math
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
import largest_error  # noqa: E402
import localization_peers_measure as peers_measure  # noqa: E402
import localization_peers_tables as peers_tables  # noqa: E402
import program  # noqa: E402
import provenance  # noqa: E402
import skipped_tests  # noqa: E402
import unkind  # noqa: E402
from peers import localization_feed, mrpt_localization  # noqa: E402

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
    right |= {"stated_m": 0.1, "stated_deg": 0.1}
    wrong = {"ate_m": 0.1, "worst_m": 0.2, "worst_deg": 1.1, "verdict": "good"}
    wrong |= {"stated_m": 0.1, "stated_deg": 1.0}
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
    assert row[1:8] == ["3", "1", "0", "2", "1", "2", "5.0"] and row[-4:] == [
        "4",
        "1",
        "4",
        "75.0 %",
    ]
    assert [list(drives_tables.faults_of(run)) for run in runs] == [
        ["ATE 0.30 m, without closing loops 0.20 m"],
        ["wrong and called good", "false loop closures: 1, up to 2.00 m, 3.0 deg off"],
        ["not mapped"],
    ]
    assert unkind.is_unforetold(wrong) and not unkind.is_unforetold({**wrong, "stated_deg": 1.2})
    assert not unkind.is_unforetold(right), "right maps need not have said so"


def check_stated_error():
    """Three standard deviations of the pose that is known the least, along its longest axis."""
    with tempfile.TemporaryDirectory() as name:
        path = pathlib.Path(name) / "trajectory.csv"
        header = "t_s,x_m,y_m,yaw_rad,xx_m2,xy_m2,xyaw_m_rad,yy_m2,yyaw_m_rad,yawyaw_rad2"
        path.write_text(f"{header}\n1,0,0,0,0,0,0,0,0,0\n2,9,9,9,0.05,0.04,9,0.05,9,0.0001\n")
        meters, degrees = largest_error.stated_error(path)
        assert abs(meters - 3 * 0.3) < 1e-9 and abs(degrees - math.degrees(0.03)) < 1e-9


def check_localization_feed():
    """What the peers are given is what the log and the map say: beams, no returns, walls, mount."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        flaser = "FLASER 3 1 8 0 0 0 0 0 0 0 5.25 host 5.25"
        robotlaser = "ROBOTLASER1 0 -1 2 1 8 0 0 3 2 9 4 0 0 0 0 0 0 0 0 0 0 0 6.5 host 6.5"
        text = ["PARAM robot_front_laser_max 8 5 host 5", flaser, robotlaser, "ODOM 0 0 0"]
        (folder / "log.clf").write_text("\n".join(text))
        (folder / "o.tum").write_text("5.25 1 2 0 0 0 0 1\n6.5 3 4 0 0 0 1 0\n")
        odometry = localization_feed.odometry_of(folder / "o.tum")
        first, second = localization_feed.scans_of(folder / "log.clf", odometry)
        assert (first.stamp, second.stamp) == ("5.25", "6.5")
        assert (
            first.odom_T_robot == (1.0, 2.0, 0.0) and abs(second.odom_T_robot[2] - math.pi) < 1e-9
        )
        assert list(first.ranges_m) == [1.0, 8.0, 8.0] and list(second.ranges_m) == [2.0, 8.0, 4.0]
        assert (first.angle_rad, first.step_rad) == (-0.5 * math.pi, 0.5 * math.pi)
        assert (second.angle_rad, second.step_rad, second.range_max_m) == (-1.0, 1.0, 8.0)
        (folder / "map.yaml").write_text(
            "resolution: 0.5\norigin: [-1, 2, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
        )
        (folder / "map.pgm").write_bytes(b"P5\n2 2\n255\n" + bytes([254, 0, 205, 254]))
        cells = localization_feed.cells_of(folder)
        assert cells.states == bytes([1, 0, 0, 2]) and cells.size_m == (1.0, 1.0), cells
        (folder / "robot.toml").write_text("x_m = 9\n[[lidars]]\nx_m = 1\ny_m = 2\nyaw_rad = 3 #\n")
        assert localization_feed.mount_of(folder / "robot.toml") == (1.0, 2.0, 3.0)


def check_mrpt():
    """The motion between two poses, and the estimate in what the program says."""
    x, y, yaw = mrpt_localization.increment_of((1.0, 1.0, 0.5 * math.pi), (1.0, 3.0, -math.pi))
    assert max(abs(x - 2.0), abs(y), abs(yaw - 0.5 * math.pi)) < 1e-9, (x, y, yaw)
    said = "PDF estimation: (1.500,-2.000,90.00deg), ESS (B.R.)= 0.5 tr(cov): 0.25\n"
    assert mrpt_localization.ESTIMATE.findall(said) == [("1.500", "-2.000", "90.00", "0.25")]


def check_localization_peers():
    """What is counted of a run of four scans: two right, one wrong and certain, one without a pose;
    and how two runs of two drives become a line."""
    truth = {"1.0000": (0.0, 0.0, 0.0), "2.0000": (1.0, 0.0, 3.1)}
    truth |= {"3.0000": (2.0, 0.0, 0.0), "4.0000": (3.0, 0.0, 0.0)}
    rows = [("1.0", 9.0, 9.0, 0.0, 0.1), ("1.0", 0.0, 0.1, 0.0, 0.1)]  # one stamp twice
    rows += [("2.0", 1.0, 0.0, 3.1 - 2.0 * math.pi, 0.6), ("3.0", 2.5, 0.0, 0.0, 0.1)]
    rows += [("9.0", 0.0, 0.0, 0.0, 0.0)]
    found = peers_measure.figures_of(rows, {"cpu_s": 0.008, "peak_mb": 20.0}, truth)
    assert found == {
        "scans": 4,
        "right": 0.5,
        "median_m": 0.1,
        "most_m": 0.5,
        "certain": 0.5,
        "wrong": 0.25,
        "less_wrong": 0.25,
        "ms_per_scan": 2.0,
        "peak_mb": 20.0,
    }, found
    guess = peers_measure.start_near((1.0, 2.0, 3.0), 1)
    assert guess == peers_measure.start_near((1.0, 2.0, 3.0), 1) and guess[:3] != (1.0, 2.0, 3.0)

    when = provenance.circumstances("loopstone 1.2.3")

    def run(system, seed, share):
        made = {"system": system, "start": "known", "seed": seed, "when": when}
        return {**found, **made, "right": share}

    first = [run("loopstone", 1, 1.0), run("amcl", 1, 0.5), run("amcl", 2, 0.7)]
    first[1]["ms_per_scan"], first[2]["ms_per_scan"] = 4.0, 8.0
    second = [run("loopstone", 1, 0.8), run("amcl", 1, 0.2)]
    line = peers_tables.summary([first, second], "known", "amcl")
    assert abs(line["right"] - 0.4) < 1e-9 and line["worst"] == 0.2 and line["ratio"] == 2.0, line
    assert peers_tables.summary([first, second], "known", "mrpt") is None
    text = peers_tables.text_of({"intel": first})
    assert provenance.stamps_of(text)[0][1] == "1.2.3", text
    assert "| intel, from a guess | 100.0 | 60.0 (50.0 to 70.0) | - |" in text, text


def main():
    check_localization_feed()
    check_mrpt()
    check_localization_peers()
    check_drives()
    check_drives_tables()
    check_stated_error()
    check_skipped_tests()
    check_comparison()
    check_peak_memory()
    check_scripts_load()
    check_provenance()
    check_run()


if __name__ == "__main__":
    main()
