"""Plots, notebooks, and what other packages take."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import loopstone as ls


def test_results_are_drawn(result: ls.MapResult, drive: ls.Simulation) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    assert result.map is not None
    for drawn in (result, result.map, drive.map):
        axes: Any = drawn.plot()
        assert axes.get_xlabel() == "x [m]" and len(axes.images) == 1
    _, ax = plt.subplots()
    assert result.plot(ax) is ax
    plt.close("all")


def test_the_legend_covers_nothing_of_the_map(result: ls.MapResult) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    _, (left, right) = plt.subplots(1, 2, layout="constrained")
    for axes in (result.plot(), result.plot(left), result.plot(right)):
        figure: Any = axes.get_figure()
        figure.canvas.draw()
        legend: Any = axes.get_legend()
        shown = legend.get_window_extent()
        assert not shown.overlaps(axes.get_window_extent())
        assert not shown.overlaps(axes.xaxis.label.get_window_extent())
        assert figure.bbox.y0 <= shown.y0
        assert "path" in [text.get_text() for text in legend.get_texts()]
    plt.close("all")


def test_notebooks_show_map_and_verdict(result: ls.MapResult, drive: ls.Simulation) -> None:
    shown: Any = result
    html = shown._repr_html_()
    assert "data:image/png;base64," in html and result.verdict.overall in html
    png = b"\x89PNG\r\n"
    assert result.map is not None
    for shown in (result.map, drive.map):
        assert shown._repr_png_().startswith(png)
    # One picture, not two: a page shows every form that an object has.
    assert html.count("<img") == 1 and not hasattr(result, "_repr_png_")
    assert result.to_png().startswith(png)


def test_to_pandas(result: ls.MapResult) -> None:
    pytest.importorskip("pandas")
    frame = result.trajectory.to_pandas()
    assert list(frame.columns) == ["x_m", "y_m", "yaw_rad"]
    np.testing.assert_array_equal(frame.index, result.trajectory.stamps_ns)
    np.testing.assert_array_equal(frame.to_numpy(), result.trajectory.poses)


def test_to_networkx(result: ls.MapResult) -> None:
    nx = pytest.importorskip("networkx")
    graph = result.graph.to_networkx()
    assert graph.number_of_nodes() == len(result.graph.poses)
    assert graph.number_of_edges() == len(result.graph.edges)
    assert nx.is_weakly_connected(graph)
    assert graph.nodes[0]["pose"] == tuple(result.graph.poses[0])


def test_a_missing_package_is_named(result: ls.MapResult, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    for package in ("pandas", "networkx", "matplotlib", "matplotlib.pyplot", "gtsam"):
        monkeypatch.setitem(sys.modules, package, None)
    calls: list[tuple[str, Any]] = [
        ("pandas", result.trajectory.to_pandas),
        ("networkx", result.graph.to_networkx),
        ("plot", result.plot),
        ("gtsam", result.graph.to_gtsam),
    ]
    for extra, call in calls:
        with pytest.raises(ImportError, match=rf"loopstone\[{extra}\]"):
            call()
