# %% [markdown]
# # 1. A first map
#
# From a drive to a map, a verdict on it, its errors against the truth, and files that other
# programs read. Nothing is needed but the package: `pip install 'loopstone[notebooks]'`. The drive
# is simulated, so the truth is known.
#
# Units are metres, radians and seconds. A pose is `(x, y, yaw)`: x forward, y left, yaw
# counter-clockwise.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import loopstone as ls

plt.rcParams.update({"figure.dpi": 80, "figure.constrained_layout.use": True, "font.size": 9})

# %% [markdown]
# ## The drive
#
# A robot drives through an office of about 1,000 m². It has a laser scanner of 180° with one beam
# a degree, wheel encoders and a gyro, and its wheels slip now and then. `drive` holds what the
# sensors sent, in the order of time, and the truth beside it.

# %%
drive = ls.simulate(
    "office",
    seed=2,
    laser__beams=181,
    laser__fov_rad=np.pi,
    laser__rate_hz=5.0,
    realism__wheels__on=True,
)
scans = [message for message in drive if isinstance(message, ls.LaserScan)]
print(f"{len(drive)} messages, {len(scans)} of them scans")
print(f"{drive.duration_s:.0f} s, {drive.route_length_m:.0f} m")

# %% [markdown]
# What the mapper will see is one scan after the other: returns of the laser in the robot's frame.
# What it will not see is the right picture, the building and the way through it.

# %%
fig, (left, right) = plt.subplots(1, 2, figsize=(10, 3.9), width_ratios=(1, 1.9))
points = scans[400].points()
left.plot(points[:, 0], points[:, 1], ".", color="tab:blue", markersize=3)
left.plot(0, 0, marker=(3, 0, -90), color="black", markersize=9)
left.set(title="one scan", xlabel="x, robot [m]", ylabel="y, robot [m]", aspect="equal")

drive.map.plot(right)
true_path = drive.truth.poses
right.plot(true_path[:, 0], true_path[:, 1], color="tab:green", linewidth=1)
right.plot(*true_path[400, :2], "o", color="tab:red")
right.set_title("the truth: building, way (green), place of that scan (red)")
plt.show()

# %% [markdown]
# ## The map
#
# One call. It takes a path of a recording, too: notebook 2 is about those. In a notebook, a bare
# `result` in the last line of a cell shows map and verdict by itself.

# %%
result = ls.map(drive)
print(result.verdict)
standing = [closure for closure in result.loop_closures if closure.stands]
print(f"{len(result.trajectory)} poses, {result.trajectory.path_length_m:.0f} m")
print(f"{len(standing)} loop closures stand, of {len(result.loop_closures)} that were tried")
print(f"a part of the map may be off by {result.possible_error_m:.2f} m")
assert result.verdict.overall == "good"

# %%
fig, ax = plt.subplots(figsize=(8.5, 5.4))
result.map.plot(ax)
path = result.trajectory.poses
ax.plot(path[:, 0], path[:, 1], color="tab:blue", linewidth=1, label="path")
nodes = result.graph.poses
for closure in standing:
    ends = nodes[[closure.from_node, closure.to_node]]
    ax.plot(ends[:, 0], ends[:, 1], color="tab:red", linewidth=0.6, alpha=0.6)
ax.plot([], [], color="tab:red", linewidth=1, label="loop closures")
fig.legend(loc="outside lower center", ncols=2, frameon=False)
ax.set_title("the map: white is free, black occupied, grey unknown")
plt.show()

# %% [markdown]
# The path is cut into submaps of some metres each. A loop closure (red) says that two submaps show
# the same walls, and how they lie to each other; it is drawn from the first pose of the one to the
# first pose of the other. Closures are what keeps a long drive from drifting apart.
#
# ## Why is it called good?
#
# The mapper does not know the truth. It asks whether the visits to a place agree: is each wall
# where the other visits saw it, did a beam go through it, is the graph solved to its optimum. Each
# measure has a verdict of its own, and the worst one counts
# ([quality](../../docs/quality.md)).

# %%
for measure in result.verdict.measures:
    print(f"{measure.verdict:8} {measure.title:28} {measure.value:8.4f}  {measure.name}")

# %% [markdown]
# ## How far off is it?
#
# Here the truth is known, so errors can be measured. `ls.evaluate` compares positions at the same
# time after the best rigid alignment (absolute trajectory error, ATE) and over pieces of the way
# (relative pose error, RPE). Three paths are compared: by wheels and gyro alone, by scan matching
# without loop closing, and the full result.

# %%
matched = ls.map(drive, loop_closure=False)
paths = {
    "odometry": result.odometry,
    "matching alone": matched.trajectory,
    "loops closed": result.trajectory,
}
errors = {name: ls.evaluate(path, drive.truth) for name, path in paths.items()}
print("                  ATE rmse   ATE max   RPE over 1 m   heading rmse")
for name, error in errors.items():
    ate, rpe = error.ate_translation_m, error.rpe_translation_m
    turn = np.degrees(error.ate_rotation_rad.rmse)
    print(f"{name:16} {ate.rmse:8.3f} m {ate.max:7.3f} m {rpe.rmse:12.4f} m {turn:12.3f}°")

assert errors["loops closed"].ate_translation_m.rmse < 0.05
assert errors["loops closed"].ate_translation_m.rmse < errors["odometry"].ate_translation_m.rmse


# %%
def aligned(path, error):
    """Positions of a path after the alignment that the evaluation chose."""
    x, y, yaw = error.reference_T_estimate
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    return path.poses[:, :2] @ turn.T + (x, y)


colours = {"odometry": "tab:orange", "matching alone": "tab:purple", "loops closed": "tab:blue"}
fig, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), width_ratios=(1.5, 1))
left.plot(true_path[:, 0], true_path[:, 1], color="black", linewidth=2.5, alpha=0.35, label="truth")
for name, path in paths.items():
    xy = aligned(path, errors[name])
    true_xy = np.array([drive.truth.at(int(stamp))[:2] for stamp in path.stamps_ns])
    left.plot(xy[:, 0], xy[:, 1], color=colours[name], linewidth=1, label=name)
    off = np.maximum(np.hypot(*(xy - true_xy).T), 1e-4)
    right.semilogy(path.t - path.t[0], off, color=colours[name], linewidth=1)
left.set(title="paths, best aligned", xlabel="x [m]", ylabel="y [m]", aspect="equal")
right.set(title="distance from the truth", xlabel="time [s]", ylabel="error [m]", ylim=(1e-4, None))
right.grid(alpha=0.3)
fig.legend(loc="outside lower center", ncols=4, frameon=False)
plt.show()

# %% [markdown]
# Odometry is off by metres because its errors add up. Matching each scan to the last few metres of
# the map leaves centimetres at most. Closing loops keeps the error from growing with time, which
# matters more the longer the drive.
#
# ## Files
#
# `save` writes what the program `loopstone map` writes: all of it or nothing. `force` replaces what
# an earlier run left there.

# %%
out = Path("out")
result.save(out / "map", force=True)
print("  ".join(sorted(path.name for path in (out / "map").iterdir())))
print()
print((out / "map" / "map.yaml").read_text())

# %% [markdown]
# - `report.html`: everything on one page, for people; `summary.json`: every figure, for scripts.
# - `map.yaml` and `map.pgm`: as `map_server` of ROS and ROS 2 reads them.
# - `trajectory.tum`: for evo and others; `trajectory.csv` has covariances, too.
# - `graph.g2o`: the pose graph, for g2o, GTSAM, Ceres, or `ls.optimize` (notebook 4).
#
# Each part can be written or handed over by itself, and read again.

# %%
result.trajectory.save(out / "path.tum")
result.graph.save(out / "graph.g2o")
result.map.to_grid().save(out / "office.yaml")

again = ls.read_map(out / "office.yaml")
np.testing.assert_array_equal(again.cells, result.map.to_grid().cells)
print("first pose as TUM:", result.trajectory.to_tum().splitlines()[0])
print("map:", again.shape, "cells of", again.resolution_m, "m, lower left corner at", again.origin)
print(
    "free:", f"{np.mean(again.cells == 0):.1%}", " occupied:", f"{np.mean(again.cells == 100):.1%}"
)

# %% [markdown]
# `result.trajectory.to_pandas()`, `result.graph.to_networkx()` and `result.graph.to_gtsam()` are
# there where those packages are installed.
#
# ## Try
#
# - Another world: `ls.world_names()` lists them. In `"corridor"` nothing tells the laser how far
#   it went. Who does, and what does the result say about that?
# - A worse laser: `laser__noise_m=0.03`, `laser__range_max_m=5.0`. From where on is the verdict
#   not good any more, and is it right?
# - A finer map: `ls.map(drive, map__resolution_m=0.02)`.
