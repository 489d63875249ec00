from __future__ import annotations

import gc
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loopstone as ls
from loopstone.options import MapOptions

# Files that tell how long a run took, or by which command it was made.
OF_THE_RUN = {"summary.json", "report.html"}


def test_files_are_those_of_the_program(
    log: Path, result: ls.MapResult, tmp_path: Path, run: Any
) -> None:
    ours, theirs = tmp_path / "ours", tmp_path / "theirs"
    result.save(ours)
    run("map", log, "-o", theirs, "--quiet")
    names = sorted(path.name for path in theirs.iterdir())
    assert sorted(path.name for path in ours.iterdir()) == names
    assert {"trajectory.tum", "map.pgm", "map.png", "graph.g2o", "options.toml"} <= set(names)
    for name in set(names) - OF_THE_RUN:
        assert (ours / name).read_bytes() == (theirs / name).read_bytes(), name
    summary = json.loads((theirs / "summary.json").read_text())
    for key in ("scans", "key_scans", "graph_cost", "path_length_m", "map_area_m2"):
        assert result.summary[key] == summary[key], key
    # By what the program knows its own results again.
    assert set(result.summary) == set(summary) - {"result_of"}


def test_options_reach_the_mapper_as_those_of_the_program_do(
    log: Path, tmp_path: Path, run: Any
) -> None:
    ours, theirs = tmp_path / "ours", tmp_path / "theirs"
    made = ls.map(log, map__resolution_m=0.1, loop_closure=False, start_s=5.0, max_scans=100)
    made.save(ours)
    cut = ["--start", "5", "--max-scans", "100", "--no-loop-closure"]
    run("map", log, "-o", theirs, "--quiet", "--set", "map.resolution_m=0.1", *cut)
    for name in ("trajectory.tum", "map.pgm", "options.toml"):
        assert (ours / name).read_bytes() == (theirs / name).read_bytes(), name


def test_threads_change_nothing(log: Path, result: ls.MapResult) -> None:
    alone = ls.map(log, threads=1)
    np.testing.assert_array_equal(alone.trajectory.poses, result.trajectory.poses)
    assert alone.map is not None and result.map is not None
    np.testing.assert_array_equal(alone.map.log_odds, result.map.log_odds)


def test_messages_make_the_map_of_their_log(log: Path, result: ls.MapResult) -> None:
    opened = ls.open_log(log)
    made = ls.map(list(opened), robot=iter(opened).robot)
    np.testing.assert_array_equal(made.trajectory.poses, result.trajectory.poses)


def test_the_parts_fit_together(drive: ls.Simulation, result: ls.MapResult) -> None:
    path = result.trajectory
    assert len(path) == drive.scans == result.summary["scans"]
    assert path.poses.shape == (len(path), 3) and path.t.shape == (len(path),)
    np.testing.assert_array_equal(path.stamps_ns, drive.truth.stamps_ns)
    np.testing.assert_allclose(path.t, path.stamps_ns * 1e-9)
    covariances = result.covariances
    assert covariances is not None and covariances.shape == (len(path), 3, 3)
    assert (np.linalg.eigvalsh(covariances[-1]) > 0).all()
    assert len(result.graph.poses) == len(result.node_stamps_ns)
    assert result.verdict.overall in {"unknown", "good", "doubtful", "bad"}
    assert result.possible_error_m >= 0.0
    assert [m.name for m in result.verdict.measures]
    assert result.complete
    assert len(result.odometry) == len(path)


def test_the_map_is_near_the_truth(drive: ls.Simulation, result: ls.MapResult) -> None:
    errors = ls.evaluate(result, drive.truth)
    assert errors.ate_translation_m.rmse < 0.05
    assert errors.poses == len(drive.truth)


def test_cells_are_where_the_map_says(result: ls.MapResult, tmp_path: Path) -> None:
    made = result.map
    assert made is not None
    rows, columns = made.shape
    assert made.log_odds.shape == made.observed.shape == (rows, columns)
    left, right, bottom, top = made.extent
    np.testing.assert_allclose(made.origin, [left, bottom])
    assert right - left == pytest.approx(columns * made.resolution_m)
    assert top - bottom == pytest.approx(rows * made.resolution_m)
    # Where the robot drove it is free.
    x, y, _ = result.trajectory.poses[len(result.trajectory) // 2]
    cell = int((y - bottom) / made.resolution_m), int((x - left) / made.resolution_m)
    assert made.observed[cell] and made.probability[cell] < 0.3
    grid = made.to_grid()
    assert set(np.unique(grid.cells)) == {-1, 0, 100}
    grid.save(tmp_path / "map.yaml")
    np.testing.assert_array_equal(ls.read_map(tmp_path / "map.yaml").cells, grid.cells)


def test_views_share_memory_and_outlive_their_owners(log: Path) -> None:
    made = ls.map(log, max_scans=50)
    assert made.map is not None
    views: list[Any] = [
        made.trajectory.poses,
        made.map.log_odds,
        made.map.observed,
        made.graph.poses,
    ]
    again: list[Any] = [
        made.trajectory.poses,
        made.map.log_odds,
        made.map.observed,
        made.graph.poses,
    ]
    for view, same in zip(views, again):
        assert not view.flags.writeable
        assert view.__array_interface__["data"] == same.__array_interface__["data"]
    before = [view.copy() for view in views]
    del made, again, same
    gc.collect()
    for view, copy in zip(views, before):
        np.testing.assert_array_equal(view, copy)


def test_a_folder_that_holds_something_is_left_alone(result: ls.MapResult, tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("years of work")
    with pytest.raises(ls.UsageError, match="holds files already"):
        result.save(tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["thesis.txt"]
    result.save(tmp_path, force=True)
    assert (tmp_path / "map.pgm").exists()


def test_progress_is_told(log: Path) -> None:
    told: list[ls.Progress] = []
    ls.map(log, progress=told.append)
    assert {p.step for p in told} and all(p.fraction is None or 0 <= p.fraction <= 1 for p in told)


def test_a_bar_needs_nothing_but_tqdm(log: Path, capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("tqdm")
    ls.map(log, max_scans=30, progress=True)
    assert "Traceback" not in capfd.readouterr().err


def test_what_a_callback_raises_ends_the_run(long_log: Path) -> None:
    class Enough(Exception):
        pass

    def stop(progress: ls.Progress) -> None:
        raise Enough

    with pytest.raises(Enough):
        ls.map(long_log, progress=stop)


def test_a_log_without_scans_is_refused(tmp_path: Path, run: Any) -> None:
    path = tmp_path / "empty.log"
    path.write_text("# CARMEN Logfile\nODOM 0 0 0 0 0 0 1.0 host 1.0\n")
    with pytest.raises(ls.DataError) as caught:
        ls.map(path)
    assert str(caught.value) in run("map", path, "-o", tmp_path / "out", code=1).stderr


def test_options_may_be_an_object_a_mapping_or_a_file(log: Path, tmp_path: Path) -> None:
    options = MapOptions()
    options.map.resolution_m = 0.1
    path = tmp_path / "options.toml"
    path.write_text(options.to_toml())
    texts = {
        ls.map(log, max_scans=20, options=given).options_toml
        for given in (options, {"map.resolution_m": 0.1}, path, str(path))
    }
    assert texts == {options.to_toml()}


def test_the_floor_in_colour(tmp_path: Path, run: Any) -> None:
    run("simulate", "office", "-o", tmp_path, "--rgbd", "--duration", "8", "--quiet")
    made = ls.map(tmp_path)
    texture = made.texture
    assert texture is not None and texture.frames_used > 0
    rows, columns = texture.shape
    assert texture.colours.shape == (rows, columns, 3) and texture.colours.dtype == np.uint8
    seen = texture.coverage == 255
    assert seen.sum() * texture.resolution_m**2 == pytest.approx(texture.seen_area_m2, rel=0.01)
    assert texture.colours[seen].mean() > texture.colours[~seen].mean()


def test_without_a_camera_there_is_no_texture(result: ls.MapResult) -> None:
    assert result.texture is None
