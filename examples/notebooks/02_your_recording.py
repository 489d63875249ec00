# %% [markdown]
# # 2. Your own recording
#
# What is in a log, what was chosen of it, a map, and what to do when the verdict is not good.
# Everything works for a ROS 1 bag, a rosbag2 folder, an MCAP file, a CARMEN log and the other
# formats of [formats](../../docs/formats.md), without ROS.

# %%
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import loopstone as ls

plt.rcParams.update({"figure.dpi": 80, "figure.constrained_layout.use": True, "font.size": 9})
OUT = Path("out")  # what this notebook writes
OUT.mkdir(exist_ok=True)


def loopstone(*arguments):
    """The program, which came with the package; prints what it prints."""
    command = [sys.executable, "-m", "loopstone", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True)
    print(done.stdout.strip() or done.stderr.strip())
    done.check_returncode()


# %% [markdown]
# ## A recording to begin with
#
# So that this notebook runs from nothing, it records a drive itself: a simulated robot whose laser
# sits 2 cm farther ahead than its owner thinks and looks 2° to the left. The log becomes a rosbag2
# folder by `loopstone convert`, as any log becomes another.

# %%
as_told = ls.Robot()  # what the owner believes
text = as_told.to_toml()
text = text.replace("x_m = 0.14  # ahead of the robot's", "x_m = 0.16  # ahead of the robot's", 1)
text = text.replace("yaw_rad = 0.0  # where its x axis", "yaw_rad = 0.0349  # where its x axis", 1)
as_built = ls.Robot(text)
print("laser on the robot: told", as_told.robot_T_lidars, " built", as_built.robot_T_lidars)

drive = ls.simulate(
    "office",
    seed=4,
    robot=as_built,
    duration_s=300.0,
    laser__beams=361,
    laser__rate_hz=5.0,
    odometry_poses=True,
)
drive.save(OUT / "recording.mcap", "mcap")
to_rosbag2 = ["--format", "rosbag2", "--force", "--quiet"]
loopstone("convert", OUT / "recording.mcap", OUT / "recording", *to_rosbag2)

# %% [markdown]
# **Put the path of your own recording here.** All that follows works on it; the checks that need
# the truth of the simulation are left out then.

# %%
LOG = "out/recording"

# %%
is_simulated = LOG == "out/recording"

# %% [markdown]
# ## What is in it?
#
# `summary()` reads the log once and tells what there is, what is odd about it, and whether a map
# can be made. `findings` are sorted, worst first; an `error` means that there is no way to a map.

# %%
summary = ls.open_log(LOG).summary()
print(summary.format, "|", summary.scans, "scans |", f"{summary.duration_s:.0f} s")
print(summary.verdict)
for kind, words in summary.findings:
    print(f"{kind}: {words}")
for topic in summary.to_dict().get("topics", []):
    role = topic["role"] or topic["remark"]
    print(f"{topic['name']:12} {topic['type']:24} {topic['messages']:6} messages  {role}")

# %% [markdown]
# Where a recording leaves a choice, one was made. `choices` says which: the robot's frame, lasers
# with their mounts as tf tells them, and whose odometry counts.

# %%
messages = iter(ls.open_log(LOG))
first_scan = next(message for message in messages if isinstance(message, ls.LaserScan))
for choice in messages.choices:
    print(choice)

# %% [markdown]
# To choose differently, name topics by their role; several lasers may be named, and an empty list
# leaves a role empty. Other switches tell the robot's frame (`base_frame=`), whose stamps count
# (`stamps=`), and which heights of a point cloud make the scan (`slice_m=`).

# %%
without_odometry = ls.open_log(LOG, topics={"odometry": []})
print(without_odometry.summary().counts)

# %% [markdown]
# ## Look before you map
#
# Four things go wrong most often, and each can be seen here. A scan that is mirrored or turned: in
# the left picture the robot looks along x, and what is on its left must have positive y. Scans
# that are missing, or stamps that jump: in the middle. A laser that sees the robot itself: a peak
# at very short ranges, on the right.

# %%
scans = [message for message in ls.open_log(LOG) if isinstance(message, ls.LaserScan)]
stamps = np.array([scan.stamp_ns for scan in scans])
ranges = np.concatenate([scan.ranges_m for scan in scans[::10]])
ranges = ranges[np.isfinite(ranges)]

fig, (a, b, c) = plt.subplots(1, 3, figsize=(10, 3.3))
points = first_scan.points()
a.plot(points[:, 0], points[:, 1], ".", color="tab:blue", markersize=3)
a.plot(0, 0, marker=(3, 0, -90), color="black", markersize=8)
a.set(title="first scan", xlabel="x, robot [m]", ylabel="y, robot [m]", aspect="equal")
b.plot((stamps[1:] - stamps[0]) / 1e9, np.diff(stamps) / 1e9, ".", color="tab:blue", markersize=2)
b.set(title="time between scans", xlabel="time [s]", ylabel="interval [s]", ylim=(0, None))
c.hist(ranges, bins=60, color="tab:blue")
c.set(title="ranges", xlabel="range [m]", ylabel="beams")
plt.show()

# %% [markdown]
# ## The robot
#
# A robot file says where sensors sit and how wheels count. What a log says itself (tf, for
# example) is believed unless a robot is given, which beats it. The top of the file:

# %%
print("\n".join(as_told.to_toml().splitlines()[:22]))

# %% [markdown]
# Write yours with `Path("robot.toml").write_text(...)` and read it by `ls.Robot.read`. Here the
# owner's belief is used on purpose, although it is wrong.
#
# ## The map

# %%
robot = as_told if is_simulated else None
result = ls.map(ls.open_log(LOG, robot=robot))
print(result.verdict)
for warning in result.warnings:
    print("-", warning)
if is_simulated:
    assert result.verdict.overall == "good"
    assert ls.evaluate(result, drive.truth).ate_translation_m.rmse < 0.02

fig, ax = plt.subplots(figsize=(7.5, 4.8))
result.map.plot(ax)
path = result.trajectory.poses
ax.plot(path[:, 0], path[:, 1], color="tab:blue", linewidth=1)
ax.set_title(f"{LOG}: verdict {result.verdict.overall}")
plt.show()

# %% [markdown]
# ## Calibration
#
# Laser and odometry both tell how the robot moved. Where they differ in a steady way, something is
# mounted or scaled otherwise than told. Each value comes with one standard deviation, and with
# whether this drive shows it at all: a robot that never turns can't know where its laser sits.
# What is wrong beyond doubt is corrected in the path ([calibration](../../docs/calibration.md)).

# %%
found = result.summary["calibration"]
told_apart = [
    ("laser ahead of the centre", ("lidar", "x_m"), 1000, "mm"),
    ("laser to the left of it", ("lidar", "y_m"), 1000, "mm"),
    ("laser looks left by", ("lidar", "yaw_rad"), 180 / np.pi, "deg"),
    ("odometry's way / true way", ("odometry", "translation_scale"), 1, ""),
    ("odometry's turns / true ones", ("odometry", "rotation_scale"), 1, ""),
    ("scans later than stamped", ("laser_delay_s",), 1000, "ms"),
]
print("                                   found    sigma     told")
for name, keys, scale, unit in told_apart:
    value = found
    for key in keys:
        value = (value or {}).get(key)
    if value is None:  # no odometry, several lasers, or a log that takes the laser for the robot
        print(f"{name:30} can't be told from this log")
        continue
    numbers = f"{value['value'] * scale:9.4f} {value['sigma'] * scale:8.4f}"
    told = f"{value['given'] * scale:8.2f} {unit}"
    print(f"{name:30} {numbers} {told}{'' if value['observable'] else '  not observable'}")

# %%
if is_simulated:
    x, _, yaw = as_built.robot_T_lidars[0]
    lidar = found["lidar"]
    assert found["mount_corrected"]
    assert abs(lidar["x_m"]["value"] - x) < 3 * lidar["x_m"]["sigma"]
    assert abs(lidar["yaw_rad"]["value"] - yaw) < 3 * lidar["yaw_rad"]["sigma"]
    print(f"built: {1000 * x:.0f} mm ahead, {np.degrees(yaw):.2f} deg to the left")

# %% [markdown]
# Where a mount was corrected, the program writes a robot file that says so, and the next map has
# nothing left to correct.

# %%
if found.get("mount_corrected"):
    robot_file = []
    if is_simulated:
        (OUT / "as_told.toml").write_text(as_told.to_toml())
        robot_file = ["--robot", OUT / "as_told.toml"]
    loopstone("calibrate", LOG, *robot_file, "-o", OUT / "robot.toml", "--force", "--quiet")

    second = ls.map(ls.open_log(LOG, robot=ls.Robot.read(OUT / "robot.toml")))
    print("corrected again:", second.summary["calibration"]["mount_corrected"])
    assert not second.summary["calibration"]["mount_corrected"]

# %% [markdown]
# ## When the verdict is not good
#
# Here is a map that deserves it: a building of four equal wings, a laser of 180°, wheels that
# slip, and loop closing switched off.

# %%
hard = ls.simulate(
    "wings",
    seed=9,
    laser__beams=181,
    laser__fov_rad=3.14,
    laser__rate_hz=4.0,
    realism__wheels__on=True,
    realism__gyro__on=True,
)
bad = ls.map(hard, loop_closure=False)
print(bad.verdict.overall)
for measure in bad.verdict.measures:
    if measure.verdict in ("doubtful", "bad"):
        print(f"- {measure.verdict}, {measure.title}: {measure.sentence}")
assert bad.verdict.overall == "doubtful"

# %% [markdown]
# The verdict names a place and two visits. Both are in `summary["quality"]`, so they can be drawn:
# the walls that the two visits saw there, one red, one blue.

# %%
worst = bad.summary["quality"]["contradictions"][0]
x, y = worst["x_m"], worst["y_m"]


def seen(log, path, begin_s, end_s):
    """What the scans of some seconds saw, on the map."""
    found = []
    for scan in log:
        if isinstance(scan, ls.LaserScan) and begin_s <= scan.stamp_s <= end_s:
            pose = path.at(scan.stamp_ns)
            if pose is not None:
                points = scan.points(robot=log.robot)
                c, s = np.cos(pose[2]), np.sin(pose[2])
                found.append(points @ np.array([[c, s], [-s, c]]) + pose[:2])
    return np.concatenate(found)


good = ls.map(hard)
fig, axes = plt.subplots(1, 2, figsize=(9, 4.8), sharex=True, sharey=True)
for ax, name, each in zip(axes, ("without loop closing", "loops closed"), (bad, good)):
    for colour, visit in (("tab:red", "first"), ("tab:blue", "second")):
        times = worst[f"{visit}_from_s"], worst[f"{visit}_to_s"]
        points = seen(hard, each.trajectory, *times)
        ax.plot(*points.T, ".", color=colour, markersize=1.5, label=f"{visit} visit")
    ax.set(xlim=(x - 6, x + 6), ylim=(y - 6, y + 6), xlabel="x [m]", ylabel="y [m]")
    ax.set(aspect="equal", title=f"{name}: {each.verdict.overall}")
handles, labels = axes[0].get_legend_handles_labels()
fig.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False, markerscale=6)
plt.show()

for name, each in (("without loop closing", bad), ("loops closed", good)):
    ate = ls.evaluate(each, hard.truth).ate_translation_m
    print(f"{name:22} {each.verdict.overall:5} ATE {ate.rmse:.3f} m rmse, {ate.max:.3f} m max")
assert good.verdict.overall == "good"
assert ls.evaluate(good, hard.truth).ate_translation_m.max < 0.5

# %% [markdown]
# What helps, by what the verdict complains of:
#
# - **Contradictions of visits, wall thickness:** drift that no closure took back. Drive so that
#   loops close; `loop_closures` has a `reason` for each that does not stand.
# - **Loose parts:** a branch that was seen once. Drive there and back, or end where you began.
# - **Degenerate travel:** long bare corridors. Good odometry helps, and a laser that sees farther.
# - **Breaks of the path:** scans are missing, or the robot was carried. Record again, or map a part
#   by `start_s=` and `duration_s=`.
# - **Sensors:** a laser that is blocked or mirrored, or that odometry contradicts. Look at the
#   mount; `front_end__odometry="ignore"` tells whether odometry is to blame.
# - **Left out of the log:** damaged records, a wrong topic, a wrong clock. See `findings`, and
#   choose by `topics=` and `stamps=`.
#
# A verdict that is not good is no failure of the program. It is what you wanted to know before a
# robot drives by that map.
