# %% [markdown]
# # 3. Scan matching: three tasks of a lab
#
# How does one scan lie to another, or to a map? With a guess (a), without one (b), and where the
# answer is not unique (c). All of it is `ls.match`, which returns a pose, its covariance, and a
# status that says whether to believe it ([matching](../../docs/matching.md),
# [registration](../../docs/registration.md)).

# %%
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.patches import Ellipse, Patch

import loopstone as ls

plt.rcParams.update({"figure.dpi": 80, "figure.constrained_layout.use": True, "font.size": 9})


def between(a, b):
    """a_T_b of two poses (x, y, yaw) in one frame."""
    (x, y), (c, s) = b[:2] - a[:2], (np.cos(a[2]), np.sin(a[2]))
    return np.array([c * x + s * y, -s * x + c * y, wrapped(b[2] - a[2])])


def moved(pose, points):
    """Points (N, 2) by a pose (x, y, yaw)."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return points @ np.array([[c, s], [-s, c]]) + pose[:2]


def wrapped(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


def is_right(found, truth, most_m=0.05, most_rad=np.radians(2)):
    x, y, yaw = found.pose - truth
    return np.hypot(x, y) < most_m and abs(wrapped(yaw)) < most_rad


# %% [markdown]
# ## (a) Two scans and a guess
#
# Two scans of an office, taken 0.6 s apart while the robot turned. The laser is ideal in one
# respect: all beams are measured at once, so that the truth holds for all points. Their noise is
# 1 cm. The answer is `target_T_source`: what maps points of the source onto the target.

# %%
drive = ls.simulate(
    "office",
    duration_s=60.0,
    laser__beams=361,
    laser__rate_hz=5.0,
    laser__sweep_s=0.0,
    laser__clock_offset_s=0.0,
)
scans = [message for message in drive if isinstance(message, ls.LaserScan)]
poses = drive.truth.poses
target, source = scans[150].points(), scans[153].points()
truth = between(poses[150], poses[153])
print(f"truth: x {truth[0]:.3f} m, y {truth[1]:.3f} m, yaw {np.degrees(truth[2]):.2f} deg")

methods = ["icp_point", "icp_line", "icp_plane", "gicp"]
print("\nmethod      error      yaw        explained  iterations  status")
for method in methods:
    found = ls.match(source, target, method=method, guess=(0, 0, 0))
    x, y, yaw = found.pose - truth
    print(
        f"{method:10} {1000 * np.hypot(x, y):5.2f} mm {abs(np.degrees(yaw)):7.3f} deg"
        f" {found.score:9.0%} {found.iterations:10}  {found.status}"
    )
    assert found and is_right(found, truth, 0.01, np.radians(0.5))

# %%
fig, axes = plt.subplots(1, 2, figsize=(9.5, 4), sharex=True, sharey=True)
best = ls.match(source, target, method="icp_line", guess=(0, 0, 0))
for ax, title, pose in (
    (axes[0], "guess: did not move", np.zeros(3)),
    (axes[1], "icp_line", best.pose),
):
    ax.plot(*target.T, ".", color="0.6", markersize=5, label="target")
    ax.plot(*moved(pose, source).T, ".", color="tab:blue", markersize=2.5, label="source")
    ax.set(title=title, xlabel="x, target [m]", ylabel="y, target [m]", aspect="equal")
    ax.set(xlim=(-5, 7), ylim=(-4.5, 4.5))
handles, labels = axes[0].get_legend_handles_labels()
fig.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False, markerscale=2)
plt.show()

# %% [markdown]
# All four end within millimetres of the truth from here. They differ in what distance they make
# small: to the nearest point (Besl and McKay), to the segment between the two nearest points
# (Censi), to the line fitted to the neighbourhood (Chen and Medioni), or between the lines of both
# sides (generalised ICP, Segal). Point to point needs more iterations, because points of two scans
# of a wall are not the same points: each pair holds the scan back along the wall.
#
# ### From how far away do they converge?
#
# The same two scans from 31 x 31 guesses, wrong by up to 2 m in x and y. Green: the answer is
# right. Grey: it is wrong, and the status says `not_converged`. Red would be the bad case, a wrong
# answer that is called right.


# %%
def basin(method, offsets, turn=0.0):
    """0 wrong and said so, 1 right, 2 wrong and not said, for guesses that are off in y and x."""
    grid = np.zeros((len(offsets), len(offsets)), int)
    for row, y in enumerate(offsets):
        for column, x in enumerate(offsets):
            found = ls.match(source, target, method=method, guess=truth + (x, y, turn))
            grid[row, column] = 1 if is_right(found, truth) else 2 if found else 0
    return grid


offsets = np.linspace(-2, 2, 31)
basins = {method: basin(method, offsets) for method in methods}

colours = ListedColormap(["0.85", "tab:green", "tab:red"])
fig, axes = plt.subplots(1, 4, figsize=(11, 3.3), sharey=True)
for ax, (method, grid) in zip(axes, basins.items()):
    ax.imshow(grid, origin="lower", extent=(-2, 2, -2, 2), cmap=colours, vmin=-0.5, vmax=2.5)
    ax.plot(0, 0, "+", color="black")
    ax.set(title=f"{method}: {np.mean(grid == 1):.0%}", xlabel="guess wrong in x [m]")
axes[0].set_ylabel("guess wrong in y [m]")
names = ["wrong, said so", "right", "wrong, not said"]
patches = [Patch(color=colours(i), label=name) for i, name in enumerate(names)]
fig.legend(handles=patches, loc="outside lower center", ncols=3, frameon=False)
plt.show()

right = {method: np.mean(grid == 1) for method, grid in basins.items()}
wrong_unsaid = max(np.mean(grid == 2) for grid in basins.values())
print("wrong and not said, at most:", f"{wrong_unsaid:.1%}")
assert right["icp_point"] < min(right["icp_line"], right["icp_plane"], right["gicp"])
assert wrong_unsaid < 0.01

# %% [markdown]
# Point to point has the smallest basin; the others are alike in size, and reach a metre or more.
# Another pair of scans has other basins: the less two scans share, the smaller they are.
#
# Guesses are wrong in heading, too. Sixty-four guesses for each size of turn, 0.3 m off in any
# direction, for the four ICPs and for `auto` with both scans as scans: it may search around the
# guess, and so does not depend on it within 1 m and 50°.

# %%
turns = np.arange(0, 100, 10)
shares = {method: [] for method in [*methods, "auto, scans"]}
around = np.linspace(0, 2 * np.pi, 32, endpoint=False)
for degrees in turns:
    guesses = [
        truth + (0.3 * np.cos(a), 0.3 * np.sin(a), side * np.radians(degrees))
        for a in around
        for side in (-1, 1)
    ]
    for method, share in shares.items():
        if method in methods:
            answers = [ls.match(source, target, method=method, guess=g) for g in guesses]
        else:
            answers = [ls.match(scans[153], scans[150], guess=g) for g in guesses[::4]]
        share.append(np.mean([is_right(found, truth) for found in answers]))

fig, ax = plt.subplots(figsize=(7.5, 3.4))
for method, share in shares.items():
    ax.plot(turns, 100 * np.array(share), marker="o", markersize=3, label=method)
ax.set(title="guesses 0.3 m off and turned", xlabel="guess turned by [deg]", ylabel="right [%]")
ax.grid(alpha=0.3)
fig.legend(loc="outside right center", frameon=False)
plt.show()
assert min(shares["auto, scans"][:5]) == 1.0

# %% [markdown]
# ## (b) No guess at all
#
# Where on the map was a scan taken? The correlative search compares every pose of the map by
# branch and bound, so nothing is left out, and refines the best. Thirty scans, each by itself:

# %%
answers = [ls.match(scans[k], drive.map, anywhere=True) for k in range(5, 300, 10)]
true_poses = poses[5:300:10]
errors = [np.hypot(*(found.pose - pose)[:2]) for found, pose in zip(answers, true_poses)]
print("right:", sum(map(is_right, answers, true_poses)), "of", len(answers))
print(f"median error {1000 * np.median(errors):.0f} mm; cells of the map have 50 mm")
assert all(answers) and all(map(is_right, answers, true_poses))

# %%
fig, ax = plt.subplots(figsize=(8, 5.2))
drive.map.plot(ax)
k = 15
points = scans[5 + 10 * k].points(robot=drive.robot)
ax.plot(*points.T, ".", color="tab:orange", markersize=3, label="scan at the origin: no guess")
ax.plot(
    *moved(answers[k].pose, points).T, ".", color="tab:blue", markersize=3, label="where it fits"
)
ax.plot(*answers[k].pose[:2], "o", color="tab:red", markersize=5, label="robot, found")
ax.set_title("one scan on the whole map")
fig.legend(loc="outside lower center", ncols=3, frameon=False, markerscale=1.5)
plt.show()

# %% [markdown]
# A building whose rooms are all alike has no unique answer. The search says so: the status is
# `degenerate`, which means that another pose explains the scan as well. Whoever took the first
# answer would be wrong by the distance of rooms.

# %%
alike = ls.simulate("rooms", seed=1, duration_s=100.0, laser__beams=361, laser__rate_hz=5.0)
alike_scans = [message for message in alike if isinstance(message, ls.LaserScan)]
rows = []
for k in range(5, 500, 20):
    found = ls.match(alike_scans[k], alike.map, anywhere=True)
    rows.append((found.status, is_right(found, alike.truth.poses[k], 0.1)))
for status in sorted({status for status, _ in rows}):
    hits = [hit for each, hit in rows if each == status]
    print(f"{status:12} {len(hits):3} scans, first answer right {sum(hits)} times")
assert all(hit for status, hit in rows if status == "converged")
assert sum(hit for _, hit in rows) < len(rows)

# %% [markdown]
# Only motion can tell such rooms apart: notebook 5 waits for it with particles.
#
# ## (c) A corridor, and what the covariance says of it
#
# Along a bare corridor every place looks the same, so a match tells how far the robot is from the
# walls and how it is turned, but not how far it went. Two scans 0.6 s apart, in the middle of a
# corridor of 100 m, and for comparison in the room at its end:

# %%
long_drive = ls.simulate(
    "corridor", laser__beams=361, laser__rate_hz=5.0, laser__sweep_s=0.0, duration_s=200.0
)
long_scans = [message for message in long_drive if isinstance(message, ls.LaserScan)]
long_poses = long_drive.truth.poses
places = {"corridor": 400, "room at its end": 780}


def ellipse_of(covariance, middle, scale, **style):
    """Standard deviations of x and y, drawn so many times as large."""
    variances, axes = np.linalg.eigh(covariance[:2, :2])
    width, height = 2 * scale * np.sqrt(variances[::-1])
    angle = np.degrees(np.arctan2(axes[1, 1], axes[0, 1]))
    return Ellipse(middle, width, height, angle=angle, fill=False, linewidth=2, **style)


fig, plots = plt.subplots(2, 1, figsize=(10, 5.4), height_ratios=(1, 1.4))
results = {}
for ax, (name, k) in zip(plots, places.items()):
    found = ls.match(long_scans[k + 3].points(), long_scans[k].points(), method="icp_line")
    results[name] = found
    variances, axes = np.linalg.eigh(found.covariance[:2, :2])
    direction = np.degrees(np.arctan2(axes[1, 1], axes[0, 1])).round()
    small, large = 1000 * np.sqrt(variances)
    print(
        f"{name:16} {found.status:10} sigma {small:.1f} mm and {large:.1f} mm,"
        f" along {direction % 180:.0f} deg"
    )
    ax.plot(*long_scans[k].points().T, ".", color="0.6", markersize=4)
    scale = 1 if found.status == "degenerate" else 500
    ax.add_patch(ellipse_of(found.covariance, found.pose[:2], scale, color="tab:red"))
    ax.plot(*found.pose[:2], "+", color="black")
    ax.set(xlim=(-12, 12), xlabel="x, target [m]", ylabel="y, target [m]", aspect="equal")
    enlarged = "" if scale == 1 else f", drawn {scale} times as large"
    ax.set_title(f"{name}: {found.status}, one sigma{enlarged}")
plots[0].set_ylim(-2.2, 2.2)
plots[1].set_ylim(-5, 5)
plt.show()

corridor = results["corridor"]
assert corridor.status == "degenerate"
assert results["room at its end"].status == "converged"
variances, axes = np.linalg.eigh(corridor.covariance[:2, :2])
heading_of_corridor = -long_poses[places["corridor"], 2]  # the map's x axis, seen by the robot
open_direction = np.arctan2(axes[1, 1], axes[0, 1])
assert abs(np.sin(open_direction - heading_of_corridor)) < np.sin(np.radians(2))
assert np.sqrt(variances[1]) > 100 * np.sqrt(variances[0])

# %% [markdown]
# In the corridor the ellipse has 10 m along the axis, which stands for "not known", and less than
# a millimetre across; its long axis is the direction that the scan leaves open, within a degree.
# The ellipse of the room is drawn 500 times as large to be seen at all.
#
# Is that honest? The same match from guesses that are wrong by up to 1 m along the corridor: across
# it all answers agree, along it each keeps its guess. Whoever fuses this match with odometry by its
# covariance takes the distance across and the heading from the laser and the way from the wheels.

# %%
k = places["corridor"]
true_motion = between(long_poses[k], long_poses[k + 3])
slips = np.linspace(-1, 1, 41)
answers = []
for slip in slips:
    guess = true_motion + (slip, 0.0, 0.0)
    answers.append(
        ls.match(long_scans[k + 3].points(), long_scans[k].points(), method="icp_line", guess=guess)
    )
off = np.array([found.pose - true_motion for found in answers])

fig, ax = plt.subplots(figsize=(7.5, 3.2))
ax.plot(slips, off[:, 0], ".", label="along the corridor")
ax.plot(slips, off[:, 1], ".", label="across")
ax.set(title="answers in a corridor", xlabel="guess wrong along it by [m]", ylabel="error [m]")
ax.grid(alpha=0.3)
fig.legend(loc="outside right center", frameon=False)
plt.show()
assert np.abs(off[:, 1]).max() < 0.01
assert all(found.status == "degenerate" for found in answers)

# %% [markdown]
# ## Try
#
# - Other pairs of scans: `target` and `source` with a longer time between them. When does the
#   overlap get too small, and what does the status say?
# - `ls.match(..., icp__max_pair_distance_m=0.5)`: smaller basin, faster. `icp__kernel="none"`: what
#   do outliers do?
# - Clouds in space: points of shape (N, 3) and `method="gicp"`, as `docs/python.md` has it.
