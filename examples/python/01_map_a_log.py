"""From a log to a trajectory and a map that ROS can load:  01_map_a_log.py [LOG]

Without a log it records one itself, in a simulated office.
"""

import sys

import loopstone as ls

if len(sys.argv) > 1:
    log = sys.argv[1]
else:
    log = "recorded.mcap"
    ls.simulate("office", duration_s=40.0, laser__beams=361).save(log, "mcap")

result = ls.map(log, progress=True)
result.save("map", force=True)

rows, columns = result.map.shape
standing = sum(closure.stands for closure in result.loop_closures)
print(f"{len(result.trajectory)} scans, {result.trajectory.path_length_m:.1f} m")
print(f"{len(result.graph.poses)} key scans, {standing} loop closures")
print(f"map/map.yaml: {columns} x {rows} cells of {result.map.resolution_m:.2f} m")
print(result.verdict)
