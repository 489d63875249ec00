"""Where is the robot on a known map, and how sure is that? It begins anywhere."""

import numpy as np

import loopstone as ls

drive = ls.simulate("office", duration_s=30.0, laser__beams=361)
localizer = ls.Localizer(drive.map, drive.robot)  # or a path: "map.yaml"
for message in drive:
    for estimate in localizer.add(message):
        x, y, _ = estimate.map_T_robot
        if int(estimate.stamp_s * 10) % 50 == 0:
            print(f"({x:6.2f}, {y:6.2f}) m, right to {estimate.probability:.0%}: {estimate.state}")

result = localizer.finish()
error = np.hypot(*(result.trajectory.poses[-1] - drive.truth.poses[-1])[:2])
print(f"{error:.3f} m off the truth; open localized/report.html")
result.save("localized", force=True)
assert error < 0.2
