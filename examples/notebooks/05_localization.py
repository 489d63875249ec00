# %% [markdown]
# # 5. Localisation, and what its probability means
#
# Where is the robot on a known map, from nowhere, and how far can the answer be believed? At every
# scan there is a pose, a covariance, a probability that the pose is within 0.2 m and 5° of the
# truth, and a state: `TRACKING`, `DOUBTFUL` or `LOST` ([localisation](../../docs/localization.md)).

# %%
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Ellipse

import loopstone as ls

plt.rcParams.update({"figure.dpi": 80, "figure.constrained_layout.use": True, "font.size": 9})
LASER = {"laser__beams": 181, "laser__rate_hz": 4.0}
COLOURS = {"TRACKING": "tab:green", "DOUBTFUL": "tab:orange", "LOST": "tab:red"}


def errors_of(result, truth):
    """(N, 3) estimate less truth: x, y [m] on the map, yaw [rad]."""
    path = result.trajectory
    off = path.poses - [truth.at(int(stamp)) for stamp in path.stamps_ns]
    off[:, 2] = (off[:, 2] + np.pi) % (2 * np.pi) - np.pi
    return off


def is_right(off):
    """As the probability is meant: within 0.2 m and 5 deg."""
    return (np.hypot(off[:, 0], off[:, 1]) < 0.2) & (np.abs(off[:, 2]) < np.radians(5))


# %% [markdown]
# ## From nowhere
#
# A short-sighted robot: it looks 180° ahead and no farther than 4 m. Its first scan fits several
# places of an office. Each such place is a hypothesis with a cloud of particles of its own; the
# clouds compete by how well they explain the scans as the robot drives.

# %%
drive = ls.simulate(
    "office", seed=2, duration_s=40.0, laser__range_max_m=4.0, laser__fov_rad=np.pi, **LASER
)
localizer = ls.Localizer(drive.map, drive.robot)  # no initial pose: anywhere
snapshots = {}
for message in drive:
    for estimate in localizer.add(message):
        second = estimate.stamp_s - drive.truth.t[0]
        for wanted in (0.0, 4.0, 7.0, 12.0):
            if second >= wanted and wanted not in snapshots:
                snapshots[wanted] = (estimate, localizer.particles.copy())
result = localizer.finish()

fig, axes = plt.subplots(2, 2, figsize=(10, 7.2), sharex=True, sharey=True)
for ax, (second, (estimate, particles)) in zip(axes.flat, snapshots.items()):
    drive.map.plot(ax)
    ax.plot(particles[:, 0], particles[:, 1], ".", color="tab:blue", markersize=3)
    ax.plot(
        *drive.truth.at(estimate.stamp_ns)[:2], "o", color="tab:red", markersize=9, fillstyle="none"
    )
    places = "place" if estimate.hypotheses == 1 else "places"
    ax.set_title(
        f"{second:.0f} s: {estimate.hypotheses} {places}, {estimate.state},"
        f" p = {estimate.probability:.2f}"
    )
    ax.label_outer()
ax.plot([], [], "o", color="tab:blue", markersize=4, label="particles")
ax.plot([], [], "o", color="tab:red", fillstyle="none", label="true position")
fig.legend(loc="outside lower center", ncols=2, frameon=False)
plt.show()

# %%
off = errors_of(result, drive.truth)
seconds = result.trajectory.t - result.trajectory.t[0]
states = np.array([estimate.state for estimate in result.estimates])

fig, (upper, lower) = plt.subplots(2, 1, figsize=(9, 4.4), sharex=True)
for state, colour in COLOURS.items():
    chosen = states == state
    if chosen.any():
        upper.plot(seconds[chosen], result.probability[chosen], ".", color=colour, label=state)
        lower.semilogy(seconds[chosen], np.hypot(*off[chosen, :2].T), ".", color=colour)
upper.set(title="probability and error", ylabel="probability", ylim=(-0.03, 1.03))
lower.axhline(0.2, color="0.5", linewidth=1, linestyle="--")
lower.set(xlabel="time [s]", ylabel="error [m]")
fig.legend(loc="outside lower center", ncols=3, frameon=False)
plt.show()

tracking = states == "TRACKING"
print(f"TRACKING after {seconds[tracking][0]:.1f} s, from then on at most", end=" ")
print(f"{np.hypot(*off[tracking, :2].T).max():.3f} m off")
assert is_right(off[tracking]).all() and tracking[-1]

# %% [markdown]
# Nine places fit the first scan, and each could be it, so the probability is low although the best
# guess happens to be right: the robot says that it does not know. The dashed line is the 0.2 m that
# "right" means. When it has driven enough to tell the places apart, the state becomes `TRACKING`;
# the other places are kept for a while, as unlikely ones.
#
# In a building of equal rooms there is nothing to tell them apart. Then the answer stays
# `DOUBTFUL`, as long as it takes:

# %%
rooms = ls.simulate("rooms", seed=2, duration_s=60.0, **LASER)
localizer = ls.Localizer(rooms.map, rooms.robot)
for message in rooms:
    localizer.add(message)
doubtful = localizer.finish()
last = doubtful.estimates[-1]
error = np.hypot(*errors_of(doubtful, rooms.truth)[-1, :2])
print(f"after 60 s: {last.state}, {last.hypotheses} places, p = {last.probability:.2f};", end=" ")
print(f"the best is {error:.1f} m off")
assert all(estimate.state == "DOUBTFUL" for estimate in doubtful.estimates)

# %% [markdown]
# ## Is a probability of 0.8 right in 8 of 10 cases?
#
# That is what a probability has to be held to, and a single drive can't tell. So: drives through
# several worlds, kind and unkind, and on each of them eight localisers that wake up somewhere on
# the way, know nothing, and run for 12 s. In some worlds people walk about and furniture has been
# moved since the map was drawn; rooms, wings and aisles look alike; the corridor has nothing to
# hold on to.

# %%
drives = {
    "office": ("office", {}),
    "office, changed": ("office", {"realism__moved__on": True, "people": 8}),
    "office, short sight": ("office", {"laser__range_max_m": 4.0, "laser__fov_rad": np.pi}),
    "warehouse": ("warehouse", {}),
    "equal rooms": ("rooms", {}),
    "equal wings": ("wings", {}),
    "equal aisles": ("aisles", {}),
    "corridor": ("corridor", {}),
}
runs = []
for name, (world, unkind) in drives.items():
    whole = ls.simulate(world, seed=11, **LASER, **unkind)
    known = ls.LocalizationMap(whole.map)  # prepared once
    messages = whole.messages
    stamps = np.array([message.stamp_ns for message in messages])
    for wakes_s in np.linspace(10.0, whole.duration_s - 20.0, 8):
        begin, end = np.searchsorted(stamps, stamps[0] + 1e9 * np.array([wakes_s, wakes_s + 12]))
        localizer = ls.Localizer(known, whole.robot)
        for message in messages[begin:end]:
            localizer.add(message)
        run = localizer.finish()
        runs.append((name, run, errors_of(run, whole.truth)))

stated = np.concatenate([run.probability for _, run, _ in runs])
right = np.concatenate([is_right(off) for _, _, off in runs])
states = np.array([estimate.state for _, run, _ in runs for estimate in run.estimates])
print(f"{len(runs)} runs, {len(stated)} scans")
print("\ndrive                scans   right   TRACKING   TRACKING while wrong")
names = np.concatenate([[name] * len(off) for name, _, off in runs])
for name in drives:
    mine = names == name
    tracking = states[mine] == "TRACKING"
    print(
        f"{name:20} {mine.sum():5} {right[mine].mean():7.0%} {tracking.mean():10.0%}"
        f" {np.sum(tracking & ~right[mine]):10}"
    )

# %%
bins = np.linspace(0, 1, 11)
which = np.clip(np.digitize(stated, bins) - 1, 0, 9)
means = [stated[which == k].mean() for k in range(10)]
shares = [right[which == k].mean() for k in range(10)]
counts = np.bincount(which, minlength=10)

fig, (left, middle) = plt.subplots(1, 2, figsize=(9, 4), width_ratios=(1, 1.1))
left.plot([0, 1], [0, 1], color="0.5", linestyle="--", linewidth=1)
left.plot(means, shares, color="tab:blue", linewidth=1)
left.scatter(means, shares, s=5 * np.sqrt(counts), color="tab:blue")
left.set(title="reliability", xlabel="stated probability", ylabel="share right", aspect="equal")
left.set(xlim=(-0.03, 1.03), ylim=(-0.03, 1.03))
left.grid(alpha=0.3)
middle.bar(bins[:-1] + 0.05, counts, width=0.09, color="tab:blue")
middle.set(
    title="how often it is stated", xlabel="stated probability", ylabel="scans", yscale="log"
)
plt.show()

sure = stated > 0.9
print(f"stated 0.9 or more: {sure.sum()} scans, {right[sure].mean():.1%} right")
brier, baseline = np.mean((stated - right) ** 2), right.mean() * (1 - right.mean())
print(f"Brier score {brier:.3f}; always saying the mean would have {baseline:.3f}")
assert right[sure].mean() > 0.95
assert right[states == "TRACKING"].mean() > 0.95
assert brier < baseline

# %% [markdown]
# Points on the dashed line would be perfect; large points stand for many scans. Points above it are
# modest: more is right than was stated. What a robot must not have are large points below the line
# on the right, where it is sure and wrong.
#
# Read it with care. Scans of one run are not independent, and where two places are equal, all
# scans of a run are right or wrong together: the points in the middle hang on a few dozen coins.
# Figures of many more drives, among them recorded ones, stand in
# [localisation](../../docs/localization.md#how-far-the-probability-can-be-believed).
#
# ## Is the covariance honest?
#
# The normalised estimation error squared (NEES), e^T C^-1 e, has mean 3 in three dimensions when
# covariances C are right; more means overconfident, less means wider than need be. Taken over what
# is `TRACKING` in the offices and the warehouse, where the pose is well known:

# %%
kept, spreads = [], []
for name, run, off in runs:
    if name.startswith(("office", "warehouse")):
        tracking = np.array([estimate.state for estimate in run.estimates]) == "TRACKING"
        kept.append(off[tracking])
        spreads.append(run.covariances[tracking])
kept, spreads = np.concatenate(kept), np.concatenate(spreads)
nees = np.einsum("ni,nij,nj->n", kept, np.linalg.inv(spreads), kept)
inside = np.mean(nees < 7.815)  # 95 % of a chi-square with 3 degrees of freedom
print(f"{len(nees)} poses: mean NEES {nees.mean():.2f}, {inside:.1%} within the 95 % ellipsoid")
assert nees.mean() < 3.0 and inside > 0.95

typical = np.median(spreads[:, :2, :2], axis=0)
variances, axes = np.linalg.eigh(typical)
size = 2 * np.sqrt(5.991 * variances[::-1]) * 1000  # 95 % in two dimensions
angle = np.degrees(np.arctan2(axes[1, 1], axes[0, 1]))
fig, (left, middle) = plt.subplots(1, 2, figsize=(9, 4))
left.plot(*(1000 * kept[:, :2].T), ".", color="tab:blue", markersize=2, alpha=0.5)
left.add_patch(Ellipse((0, 0), *size, angle=angle, fill=False, color="tab:red", linewidth=2))
left.set(
    title="errors, and a typical 95 % ellipse", xlabel="x [mm]", ylabel="y [mm]", aspect="equal"
)
left.set(xlim=(-70, 70), ylim=(-70, 70))
x = np.linspace(0.01, 12, 300)
middle.hist(nees, bins=np.linspace(0, 12, 49), density=True, color="tab:blue", alpha=0.6)
middle.plot(x, np.sqrt(x / (2 * np.pi)) * np.exp(-x / 2), color="tab:red")
middle.set(title="NEES: found (blue), ideal (red)", xlabel="NEES", ylabel="density", xlim=(0, 12))
plt.show()

# %% [markdown]
# The ellipse is that of the median pose; where the robot sees little along a corridor, errors are
# larger, and so are the ellipses of those poses. The covariance is wider than the errors, on the
# safe side: it allows for walls that lie anywhere
# within their cells of 5 cm, and this map is exact. On a map that was made by a robot, some of that
# room is used up.
#
# ## The wrong map
#
# The map of one office; robots that drive in that office, in other buildings, and in another office
# of the same kind.

# %%
office = ls.simulate("office", seed=1, duration_s=1.0).map
known = ls.LocalizationMap(office)
told = {}
for name, world, seed in (
    ("the right office", "office", 1),
    ("warehouse", "warehouse", 2),
    ("equal rooms", "rooms", 2),
    ("equal wings", "wings", 2),
    ("another office", "office", 2),
):
    there = ls.simulate(world, seed=seed, duration_s=25.0, **LASER)
    localizer = ls.Localizer(known, there.robot)
    for message in there:
        localizer.add(message)
    found = localizer.finish().estimates
    told[name] = {state: np.mean([e.state == state for e in found]) for state in COLOURS}
    print(f"{name:17}", "  ".join(f"{state} {share:4.0%}" for state, share in told[name].items()))

fig, ax = plt.subplots(figsize=(8, 2.8))
left_of = np.zeros(len(told))
for state, colour in COLOURS.items():
    share = 100 * np.array([shares[state] for shares in told.values()])
    ax.barh(list(told), share, left=left_of, color=colour, label=state)
    left_of += share
ax.invert_yaxis()
ax.set(title="drives on the map of one office", xlabel="share of scans [%]", xlim=(0, 100))
fig.legend(loc="outside lower center", ncols=3, frameon=False)
plt.show()

assert told["the right office"]["TRACKING"] > 0.95
for name in ("warehouse", "equal rooms", "equal wings"):
    assert told[name]["TRACKING"] == 0

# %% [markdown]
# In other buildings it never says `TRACKING`. The other office is the hard case: it has corridors
# and rooms of the same kind, so for a moment a wrong place can look right.
#
# ## Try
#
# - `initial=(x, y, yaw)` that is wrong by 3 m: how long does it take to notice?
# - A map that a robot made: `ls.map(drive).map` in the place of `drive.map`. What becomes of NEES?
# - `ls.localize(log, map)` does all of this for a recording; `save("where")` writes a report.
