"""Pictures by matplotlib, which is imported when one is asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._convert import needed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._core import FloorPlan, GridMap, MapResult, OccupancyMap


def _axes(ax: Axes | None) -> Axes:
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise needed("matplotlib", "plot") from error
    if ax is None:
        _, ax = plt.subplots(layout="constrained")
    ax.set_aspect("equal")
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    return ax


def _legend_below(ax: Axes) -> None:
    """Under the numbers and the name of the x axis: inside it would cover the map."""
    from matplotlib.figure import Figure
    from matplotlib.transforms import offset_copy

    handles, labels = ax.get_legend_handles_labels()
    figure = ax.get_figure()
    assert isinstance(figure, Figure)
    ax.legend(
        handles,
        labels,
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=offset_copy(ax.transAxes, fig=figure, y=-30.0, units="points"),
        ncols=len(labels),
        fontsize="small",
        frameon=False,
    )


def plot_grid(grid: GridMap, ax: Axes | None = None) -> Axes:
    import numpy as np

    ax = _axes(ax)
    cells = grid.cells
    grey = np.where(cells < 0, 0.8, 1.0 - cells / 100.0)
    ax.imshow(grey, origin="lower", extent=grid.extent, cmap="gray", vmin=0.0, vmax=1.0)
    return ax


def plot_occupancy(map: OccupancyMap, ax: Axes | None = None) -> Axes:
    ax = _axes(ax)
    ax.imshow(
        1.0 - map.probability, origin="lower", extent=map.extent, cmap="gray", vmin=0.0, vmax=1.0
    )
    return ax


def plot_result(result: MapResult, ax: Axes | None = None) -> Axes:
    ax = _axes(ax)
    if result.map is not None:
        plot_occupancy(result.map, ax)
    poses = result.trajectory.poses
    ax.plot(poses[:, 0], poses[:, 1], color="tab:blue", linewidth=1.0, label="path")
    nodes = result.graph.poses
    label: str | None = "loop closures"
    for closure in result.loop_closures:
        if closure.stands:
            ends = nodes[[closure.from_node, closure.to_node]]
            ax.plot(ends[:, 0], ends[:, 1], color="tab:red", linewidth=1.0, label=label)
            label = None
    ax.set_title(f"verdict: {result.verdict.overall}")
    _legend_below(ax)
    return ax


def plot_plan(plan: FloorPlan, ax: Axes | None = None) -> Axes:
    ax = _axes(ax)
    from matplotlib.collections import LineCollection

    for room in plan.rooms:
        ax.fill(*room.polygon.T, color="tab:blue", alpha=0.1, linewidth=0.0)
        for hole in room.holes:
            ax.fill(*hole.T, color="white", linewidth=0.0)
        ax.annotate(f"{room.area_m2:.1f} m²", (room.label[0], room.label[1]), ha="center")
    kinds: dict[str, tuple[Any, str, str]] = {
        "things": (plan.lines("movable"), "tab:brown", "solid"),
        "hidden walls": (plan.lines("hidden"), "0.5", "dashed"),
        "walls": (plan.lines("structure"), "black", "solid"),
        "doors": ([(door.start, door.end) for door in plan.doors], "tab:red", "solid"),
    }
    for name, (lines, color, style) in kinds.items():
        ax.add_collection(LineCollection(list(lines), colors=color, linestyles=style, label=name))
    ax.autoscale_view()
    _legend_below(ax)
    return ax
