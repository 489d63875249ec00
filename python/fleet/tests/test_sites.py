"""Logs are joined to their sites: in the order of time, none twice."""

from __future__ import annotations

import json

import pytest

from conftest import Fleet


def test_sites_take_logs_by_time(fleet: Fleet, capsys: pytest.CaptureFixture[str]) -> None:
    logs = {
        "late_at300.a": "hall",
        "early_at100.a": "hall",
        "lonely_at200.a": "hall",
        "refused_at150.a": "hall",
        "other_at5.a": "shop",
        "none_at5.a": "",
    }
    lines = [f"{fleet.log(name)},{site}" for name, site in logs.items()]
    broken = fleet.log("broken_at1.a", "bad")
    manifest = fleet.manifest([*lines, f"{broken},hall"], "log,site")
    assert fleet.run(manifest) == 0
    site = fleet.out / "sites" / "hall.sqlite"
    assert site.read_text().split() == ["early_at100.a", "lonely_at200.a", "late_at300.a"]
    rows = fleet.rows()
    assert {name: row.get("site_status") for name, row in rows.items()} == {
        "late_at300.a": "joined",
        "early_at100.a": "joined",
        "lonely_at200.a": "pending",
        "refused_at150.a": "failed",
        "other_at5.a": "joined",
        "none_at5.a": None,
        "broken_at1.a": None,
    }
    assert rows["refused_at150.a"]["site_reason"] == "refused_at150.a: does not fit"
    assert "3 joined, 1 pending" in capsys.readouterr().err.replace("1 failed, ", "")
    assert len(json.loads((fleet.out / "sites" / "hall.json").read_text())) == 4
    # A later log is added; what is there is not added again.
    more = fleet.log("more_at400.a")
    assert fleet.run(fleet.manifest([*lines, f"{more},hall"], "log,site")) == 0
    assert site.read_text().split()[3:] == ["more_at400.a"]
    assert fleet.times_mapped("site-early_at100.a") == 1


def test_a_log_is_joined_as_it_was_mapped(fleet: Fleet) -> None:
    log = fleet.log("one_at1.a")
    robots = fleet.out.parent / "robots"
    robots.mkdir()
    robot = robots / "cart.toml"
    robot.write_text("[wheels]\n")
    manifest = fleet.manifest([f"{log},hall,cart,map.resolution_m=0.02"], "log,site,robot,options")
    flags = ["--no-texture", "--topic", "laser=/scan", "imu=none", "--cloud", "--slice", "-0.1,0.3"]
    assert fleet.run(manifest, "--robots", str(robots), "--threads", "3", "--", *flags) == 0
    words = json.loads((fleet.out / "sites" / "hall.sqlite.words").read_text())
    # Without what is no matter of a site.
    assert words[:6] == ["--json", "--topic", "laser=/scan", "imu=none", "--slice", "-0.1,0.3"]
    assert words[words.index("--threads") + 1] == "3"
    assert words[words.index("--robot") + 1] == str(robot)
    assert words[-2:] == ["--set", "map.resolution_m=0.02"]


def test_without_sites_nothing_is_joined(
    fleet: Fleet, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    log = fleet.log("a")
    assert fleet.run(fleet.manifest([str(log)])) == 0
    assert "no row of the manifest names a site" in capsys.readouterr().err
    assert not (fleet.out / "sites").exists()
    monkeypatch.setenv("FAKE_NO_SITES", "1")
    assert fleet.run(fleet.manifest([f"{log},hall"], "log,site")) == 0
    assert "has no command to join sites, so 1 log" in capsys.readouterr().err
