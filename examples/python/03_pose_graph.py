"""A drive round a square whose odometry drifts; a loop closure puts it right, which is proven."""

import numpy as np

import loopstone as ls

steps = np.array([(1.0, 0.0, np.pi / 2 if i % 10 == 9 else 0.0) for i in range(40)])
measured = steps + [0.02, 0.0, np.radians(0.5)]  # 2 % too far, and a little to the left

poses = [np.zeros(3)]
for dx, _, turn in measured:
    x, y, yaw = poses[-1]
    poses.append(np.array([x + dx * np.cos(yaw), y + dx * np.sin(yaw), yaw + turn]))

edges = [(i, i + 1) for i in range(40)] + [(0, 40)]  # the last pose is the first again
information = np.array([np.diag([0.03, 0.03, 0.01]) ** 2] * 40 + [np.diag([0.01] * 3) ** 2])
graph = ls.PoseGraph(poses, edges, [*measured, np.zeros(3)], np.linalg.inv(information))

solved = ls.optimize(graph)
print(f"{solved.status} in {solved.iterations} iterations, {solved.certificate.status}")
print(f"cost {solved.cost_initial:.1f} -> {solved.cost:.2f}")
print(f"gap at the start {np.hypot(*poses[-1][:2]):.3f} -> {np.hypot(*solved.poses[-1][:2]):.3f} m")
assert solved.certificate.certified
