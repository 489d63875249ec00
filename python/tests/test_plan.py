"""Floor plans: what the package draws is what `loopstone export` draws."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loopstone as ls

ANCHOR = (48.26555, 11.67110, 93.5)
KINDS = ("svg", "pdf", "dxf", "geojson")


@pytest.fixture(scope="module")
def kept(log: Path) -> ls.MapResult:
    return ls.map(log, keep_state=True)


@pytest.fixture(scope="module")
def folder(kept: ls.MapResult, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("kept") / "first_floor"
    kept.save(path)
    return path


@pytest.fixture(scope="module")
def plan(kept: ls.MapResult) -> ls.FloorPlan:
    return ls.floor_plan(kept)


def written(plan: ls.FloorPlan, folder: Path, title: str | None) -> dict[str, bytes]:
    folder.mkdir()
    plan.write_svg(folder / "plan.svg", title=title, anchor=ANCHOR)
    plan.write_pdf(folder / "plan.pdf", title=title, anchor=ANCHOR)
    plan.write_dxf(folder / "plan.dxf")
    plan.write_geojson(folder / "plan.geojson", ANCHOR)
    return {kind: (folder / f"plan.{kind}").read_bytes() for kind in KINDS}


def exported(run: Any, map: object, folder: Path, *words: object) -> tuple[dict[str, bytes], Any]:
    """The program's files, and what it prints as JSON."""
    folder.mkdir()
    flags = [word for kind in KINDS for word in (f"--{kind}", folder / f"plan.{kind}")]
    anchor = ",".join(str(value) for value in ANCHOR)
    told = run("export", map, *flags, "--anchor", anchor, *words, "--json")
    return {kind: (folder / f"plan.{kind}").read_bytes() for kind in KINDS}, json.loads(told.stdout)


def assert_same(ours: dict[str, bytes], theirs: dict[str, bytes]) -> None:
    for kind in KINDS:
        assert ours[kind] == theirs[kind], kind


def test_files_are_those_of_the_program(
    plan: ls.FloorPlan, folder: Path, tmp_path: Path, run: Any
) -> None:
    assert plan.from_scans
    theirs, _ = exported(run, folder, tmp_path / "theirs")
    assert_same(written(ls.floor_plan(folder), tmp_path / "ours", None), theirs)
    # In memory the map has no folder, whose name stands on the sheet.
    assert_same(written(plan, tmp_path / "memory", "first_floor"), theirs)


def test_a_straightened_plan_is_that_of_the_program(
    plan: ls.FloorPlan, folder: Path, tmp_path: Path, run: Any
) -> None:
    theirs, _ = exported(run, folder, tmp_path / "theirs", "--straighten", "--title", "Über uns")
    straight = plan.straightened()
    assert_same(written(straight, tmp_path / "ours", "Über uns"), theirs)
    np.testing.assert_array_equal(plan.plan_T_map, [0.0, 0.0, 0.0])
    assert straight.plan_T_map[2] == -plan.axes[0].yaw_rad
    assert straight.axes[0].yaw_rad == pytest.approx(0.0, abs=1e-12)
    turn = ls.Pose.of(straight.plan_T_map)
    np.testing.assert_allclose(straight.lines()[:, 0], turn @ plan.lines()[:, 0], atol=1e-9)


def test_figures_are_those_of_the_program(
    plan: ls.FloorPlan, folder: Path, tmp_path: Path, run: Any
) -> None:
    _, told = exported(run, folder, tmp_path / "theirs")
    assert told["segments"] == len(plan.segments) and told["source"] == "scans"
    for layer in ("structure", "hidden", "movable"):
        length = plan.length_m(layer)
        assert told[f"{layer}_m"] == pytest.approx(length, abs=1e-3)
    assert len(plan.rooms) == len(told["rooms"]) > 0
    for room, row in zip(plan.rooms, told["rooms"]):
        assert len(room.doors) == row.pop("doors")
        assert {key: getattr(room, key) for key in row} == row
    assert len(plan.doors) == len(told["doors"]) > 0
    for door, row in zip(plan.doors, told["doors"]):
        rooms = [None if r is None else r + 1 for r in (door.room, door.other_room)]
        assert rooms == row.pop("rooms")
        assert {key: getattr(door, key) for key in row} == row
    for axis, row in zip(plan.axes, told["axes"], strict=True):
        assert {key: getattr(axis, key) for key in row} == row


def area_of(corners: Any) -> float:
    """Positive counter-clockwise."""
    x, y = corners.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def test_the_parts_fit_together(plan: ls.FloorPlan) -> None:
    for room in plan.rooms:
        area = area_of(room.polygon) + sum(area_of(hole) for hole in room.holes)
        assert area == pytest.approx(room.area_m2, rel=1e-9) and room.area_sigma_m2 > 0.0
        assert len(room.sides) == len(room.polygon)
        assert set(room.sides) <= {"wall", "hidden", "door", "open"}
        assert all(plan.rooms[0].area_m2 >= other.area_m2 for other in plan.rooms)
        (left, bottom), (right, top) = room.polygon.min(axis=0), room.polygon.max(axis=0)
        assert left < room.label[0] < right and bottom < room.label[1] < top
    for at, door in enumerate(plan.doors):
        assert door.kind == ("door" if door.width_m <= 1.4 else "opening")
        for number in (door.room, door.other_room):
            assert number is None or at in plan.rooms[number].doors
    for layer in ("structure", "hidden", "movable"):
        segments = [s for s in plan.segments if s.layer == layer]
        lines = plan.lines(layer)
        assert lines.shape == (len(segments), 2, 2)
        for line, segment in zip(lines, segments):
            np.testing.assert_array_equal(line, [segment.start, segment.end])
            along = (segment.end - segment.start) / segment.length_m
            np.testing.assert_allclose(segment.normal, [-along[1], along[0]])
            assert segment.sigma_across_m > 0.0
    assert [s.layer for s in plan.walls] == ["structure"] * len(plan.lines("structure"))
    assert len(plan.lines()) == len(plan.segments)
    left, right, bottom, top = plan.extent
    assert (plan.lines() >= [left, bottom]).all() and (plan.lines() <= [right, top]).all()
    assert f"{len(plan.rooms)} rooms" in repr(plan)


def test_of_cells_alone_it_is_coarser(
    drive: ls.Simulation, result: ls.MapResult, tmp_path: Path, run: Any
) -> None:
    drive.map.save(tmp_path / "truth.yaml")
    plan = ls.floor_plan(drive.map)
    assert not plan.from_scans and not ls.floor_plan(result).from_scans
    theirs, _ = exported(run, tmp_path / "truth.yaml", tmp_path / "theirs")
    assert_same(written(plan, tmp_path / "ours", "truth"), theirs)
    assert result.map is not None
    assert len(ls.floor_plan(result.map).segments) == len(ls.floor_plan(result).segments)


def test_a_site_is_drawn_as_by_the_program(log: Path, tmp_path: Path, run: Any) -> None:
    site = ls.Site(tmp_path / "office.site")
    site.add(log)
    theirs, _ = exported(run, site.path, tmp_path / "theirs")
    assert_same(written(ls.floor_plan(site), tmp_path / "ours", None), theirs)
    drawn = ls.floor_plan(site.map(keep_scans=True))
    assert_same(written(drawn, tmp_path / "memory", None), theirs)
    assert not ls.floor_plan(site.map()).from_scans


def test_geojson_is_that_of_its_file(plan: ls.FloorPlan, tmp_path: Path) -> None:
    plan.write_geojson(tmp_path / "plan.geojson", ANCHOR)
    assert plan.to_geojson(ANCHOR) == json.loads((tmp_path / "plan.geojson").read_text())
    with pytest.raises(ls.UsageError, match="latitude within 89.9"):
        plan.to_geojson((95.0, 0.0, 0.0))
    with pytest.raises(ls.UsageError, match="latitude within 89.9"):
        plan.write_svg(tmp_path / "plan.svg", anchor=(float("nan"), 0.0, 0.0))
    assert not (tmp_path / "plan.svg").exists()


def test_a_file_that_is_there_stays(plan: ls.FloorPlan, tmp_path: Path) -> None:
    path = tmp_path / "plan.dxf"
    path.write_text("years of work")
    with pytest.raises(ls.UsageError, match="is there already"):
        plan.write_dxf(path)
    assert path.read_text() == "years of work"
    plan.write_dxf(path, force=True)
    assert "SECTION" in path.read_text()


def test_what_is_no_map_is_refused(plan: ls.FloorPlan, tmp_path: Path, run: Any) -> None:
    with pytest.raises(ls.DataError) as none:
        ls.floor_plan(tmp_path / "nowhere.yaml")
    words = ["--svg", tmp_path / "plan.svg"]
    assert str(none.value) in run("export", tmp_path / "nowhere.yaml", *words, code=1).stderr
    with pytest.raises(ls.UsageError):
        ls.floor_plan(ls.GridMap(np.full((20, 20), -1, np.int8), 0.05, [0, 0]))
    with pytest.raises(TypeError, match="map: expected"):
        ls.floor_plan(3)  # type: ignore[arg-type]
    with pytest.raises(ls.UsageError, match="structure, hidden or movable, not roof"):
        plan.lines("roof")  # type: ignore[arg-type]


def test_it_is_drawn(plan: ls.FloorPlan) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    axes: Any = plan.plot()
    assert axes.get_xlabel() == "x [m]" and len(axes.collections) == 4
    plt.close("all")
    shown: Any = plan
    assert "<svg" in shown._repr_svg_()
