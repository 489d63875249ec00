"""Maps that are gone on with, and edited."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loopstone as ls


@pytest.fixture(scope="module")
def kept(log: Path) -> ls.MapResult:
    return ls.map(log, keep_state=True)


@pytest.fixture(scope="module")
def second(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Another drive in the same office."""
    path = tmp_path_factory.mktemp("second") / "drive.log"
    drive = ls.simulate(
        "office", seed=3, drive_seed=8, duration_s=25.0, laser__beams=181, laser__rate_hz=5.0
    )
    drive.save(path, "mcap")
    return path


def files(folder: Path) -> dict[str, bytes]:
    # A state has times in it that no two runs share.
    names = ("trajectory.tum", "graph.g2o", "map.pgm", "edits.toml")
    return {n: (folder / n).read_bytes() for n in names if (folder / n).exists()}


def test_another_drive_goes_on_with_a_map_as_by_the_program(
    kept: ls.MapResult, log: Path, second: Path, tmp_path: Path, run: Any
) -> None:
    assert kept.has_state
    run("map", log, "-o", tmp_path / "first", "--keep-state", "--quiet")
    kept.save(tmp_path / "ours")
    assert files(tmp_path / "ours") == files(tmp_path / "first")
    both = ls.map(second, continue_from=kept)
    folder = ls.map(second, continue_from=tmp_path / "first")
    run("map", second, "-o", tmp_path / "both", "--continue", tmp_path / "first", "--quiet")
    assert both.drives == 2 and not both.has_state
    assert len(both.trajectory) > len(kept.trajectory)
    for made in (both, folder):
        assert made.trajectory.to_tum() == (tmp_path / "both" / "trajectory.tum").read_text()


def test_an_older_state_does_not_stay_beside_new_results(
    kept: ls.MapResult, result: ls.MapResult, tmp_path: Path
) -> None:
    kept.save(tmp_path / "out")
    assert (tmp_path / "out" / "state.loopstone").exists()
    result.save(tmp_path / "out", force=True)
    assert not (tmp_path / "out" / "state.loopstone").exists()


def test_what_can_not_be_gone_on_with_is_refused(
    kept: ls.MapResult, result: ls.MapResult, second: Path, tmp_path: Path
) -> None:
    with pytest.raises(ls.UsageError, match="keep_state=True"):
        ls.map(second, continue_from=result)
    with pytest.raises(ls.UsageError, match="keep_state=True"):
        ls.MapEditor(result)
    with pytest.raises(ls.DataError, match="of another kind of run"):
        ls.map(second, continue_from=kept, map__resolution_m=0.1)
    with pytest.raises(ls.DataError, match="holds no state.loopstone"):
        ls.map(second, continue_from=tmp_path)
    (tmp_path / "state.loopstone").write_bytes(b"nothing")
    with pytest.raises(ls.DataError):
        ls.map(second, continue_from=tmp_path)
    with pytest.raises(TypeError, match="of logs"):
        ls.map(ls.simulate("office", duration_s=1.0, laser__beams=61), keep_state=True)


def test_edits_are_those_of_the_program(kept: ls.MapResult, tmp_path: Path, run: Any) -> None:
    editor = ls.MapEditor(kept)
    assert kept.map is not None
    left, right, bottom, top = kept.map.extent
    half = 0.5 * (left + right)
    assert editor.add("crop", box=np.array([left, bottom, half, top]))
    turned = editor.add("origin", x_m=1.0, y_m=2.0, yaw_rad=0.5)
    assert turned.applied and turned.told and len(editor) == 2
    editor.add_toml('[[edit]]\nkind = "keep_out"\nname = "stairs"\nbox = [0, 0, 1, 1]\n')
    made = editor.draw()
    assert made.map is not None and made.map.shape != kept.map.shape
    kept.save(tmp_path / "map")
    (tmp_path / "edits.toml").write_text(editor.to_toml())
    made.save(tmp_path / "ours")
    run(
        "edit",
        tmp_path / "map",
        "--edits",
        tmp_path / "edits.toml",
        "-o",
        tmp_path / "theirs",
        "--quiet",
    )
    assert files(tmp_path / "ours") == files(tmp_path / "theirs")
    assert {p.name for p in (tmp_path / "ours").iterdir()} == {
        p.name for p in (tmp_path / "theirs").iterdir()
    }
    assert made.summary["edits"]
    with pytest.raises(ls.UsageError, match="edited"):
        ls.MapEditor(made)
    with pytest.raises(ls.DataError, match="edited"):
        ls.map(tmp_path / "nowhere", continue_from=tmp_path / "ours")


def test_undo_is_to_the_last_byte_and_refusals_are_told(kept: ls.MapResult) -> None:
    editor = ls.MapEditor(kept)
    plain = editor.map_T_keys
    refused = editor.add("delete_closure", from_submap=400, to_submap=500)
    assert not refused and "refused" in repr(refused)
    with pytest.raises(ls.UsageError, match="refused"):
        editor.draw()
    assert editor.undo() and not editor.undo() and len(editor) == 0
    editor.add("origin", x_m=3.0, y_m=0.0)
    assert not np.array_equal(editor.map_T_keys, plain)
    editor.undo()
    np.testing.assert_array_equal(editor.map_T_keys, plain)
    assert [r.applied for r in editor.reports] == []
    with pytest.raises(ls.OptionsError, match="dance"):
        editor.add("dance")
    with pytest.raises(TypeError):
        editor.add("crop", box={"a": 1})
    drawn = editor.draw()
    np.testing.assert_array_equal(drawn.trajectory.poses, kept.trajectory.poses)


def test_a_folder_is_edited_as_by_the_program(
    kept: ls.MapResult, log: Path, tmp_path: Path, run: Any
) -> None:
    first, second = tmp_path / "first.toml", tmp_path / "second.toml"
    run("map", log, "-o", tmp_path / "map", "--keep-state", "--quiet")
    editor = ls.MapEditor(tmp_path / "map")
    assert editor.add("erase", box=[0.0, 0.0, 1.0, 1.0])
    first.write_text(editor.to_toml())
    editor.draw().save(tmp_path / "ours")
    run("edit", tmp_path / "map", "--edits", first, "-o", tmp_path / "theirs", "--quiet")
    assert files(tmp_path / "ours") == files(tmp_path / "theirs")
    summaries = [
        json.loads((tmp_path / name / "summary.json").read_text()) for name in ("ours", "theirs")
    ]
    for key in ("log", "warnings", "left_out", "quality"):
        assert summaries[0].get(key) == summaries[1].get(key), key
    assert [s["edits"]["edited"] for s in summaries] == [str(tmp_path / "map")] * 2

    again = ls.MapEditor(tmp_path / "ours")  # with the edits that it has
    assert len(again) > 1
    again.add("origin", x_m=2.0, y_m=1.0, yaw_rad=0.25)
    second.write_text('[[edit]]\nkind = "origin"\nx_m = 2.0\ny_m = 1.0\nyaw_rad = 0.25\n')
    again.draw().save(tmp_path / "ours2")
    run("edit", tmp_path / "theirs", "--edits", second, "-o", tmp_path / "theirs2", "--quiet")
    ours, theirs = files(tmp_path / "ours2"), files(tmp_path / "theirs2")
    for name in ("trajectory.tum", "graph.g2o", "map.pgm"):
        assert ours[name] == theirs[name], name
    assert ours["trajectory.tum"] != files(tmp_path / "ours")["trajectory.tum"]


def test_a_folder_without_a_map_is_not_edited(result: ls.MapResult, tmp_path: Path) -> None:
    with pytest.raises(ls.DataError, match="holds no map to edit"):
        ls.MapEditor(tmp_path)
    result.save(tmp_path / "map")
    with pytest.raises(ls.DataError, match="holds no state.loopstone to edit"):
        ls.MapEditor(tmp_path / "map")
    (tmp_path / "map" / "state.loopstone").write_bytes(b"nothing at all")
    with pytest.raises(ls.DataError, match="no session"):
        ls.MapEditor(str(tmp_path / "map"))
