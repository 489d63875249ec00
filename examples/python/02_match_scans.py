"""How far did the robot move between two scans? Without odometry, and how sure is that?"""

import numpy as np

import loopstone as ls

drive = ls.simulate("office", duration_s=10.0)
scans = [message for message in drive if isinstance(message, ls.LaserScan)]

found = ls.match(scans[63], scans[60])  # target_T_source: where the later scan lies
poses = drive.truth.poses
x, y = (poses[63] - poses[60])[:2]
c, s = np.cos(poses[60, 2]), np.sin(poses[60, 2])
truth = np.array([c * x + s * y, -s * x + c * y, poses[63, 2] - poses[60, 2]])

sigmas = np.sqrt(np.diag(found.covariance))
print(f"{found.status} by '{found.method}', {found.score:.0%} of the scan explained")
print(f"estimate  x {found.pose[0]:.4f} m  y {found.pose[1]:.4f} m  yaw {found.pose[2]:.4f} rad")
print(f"truth     x {truth[0]:.4f} m  y {truth[1]:.4f} m  yaw {truth[2]:.4f} rad")
print(f"believed  {1000 * np.hypot(*sigmas[:2]):.1f} mm, {sigmas[2]:.4f} rad")
assert found and np.hypot(*(found.pose - truth)[:2]) < 0.03
