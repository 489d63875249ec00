#!/usr/bin/env python3
"""Open3D (https://www.open3d.org, MIT) on scans in the plane; arguments and answers as of the C++
matchers, see bench/answers.hpp.

  open3d_matchers.py FILE MATCHER COUNT      without arguments: the names of the matchers

Points have z = 0. Open3D's own normals take the axis along which a neighbourhood is thinnest, which
would be z; so normals are fitted here in the plane to five neighbouring beams, in numpy, which
takes a fraction of a millisecond. Generalized ICP makes its covariances from these normals. Time:
CPU time of the process, from points to pose; the calls from Python cost about 0.05 ms of it.
"""
import os
import sys
import time

os.environ["OMP_NUM_THREADS"] = "1"
import numpy as np  # noqa: E402

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pairs_file import read_pairs  # noqa: E402


def normals_of(points, half=2):
    """Normals of the lines through each point and `half` neighbours on either side, in the order of
    the beams."""
    count = len(points)
    window = np.clip(np.arange(count)[:, None] + np.arange(-half, half + 1)[None, :], 0, count - 1)
    near = points[window]
    # A neighbour beyond a jump of the range is replaced by the point itself.
    jump = np.linalg.norm(near - points[:, None], axis=2) > 0.3
    near = np.where(jump[..., None], points[:, None], near)
    offset = near - near.mean(axis=1, keepdims=True)
    xx, xy, yy = (
        (offset[..., 0] ** 2).sum(1),
        (offset[..., 0] * offset[..., 1]).sum(1),
        (offset[..., 1] ** 2).sum(1),
    )
    along = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    return np.column_stack([-np.sin(along), np.cos(along), np.zeros(count)])


def cloud_of(open3d, points, with_normals):
    cloud = open3d.geometry.PointCloud()
    cloud.points = open3d.utility.Vector3dVector(np.column_stack([points, np.zeros(len(points))]))
    if with_normals:
        cloud.normals = open3d.utility.Vector3dVector(normals_of(points))
    return cloud


def matcher(open3d, name):
    registration = open3d.pipelines.registration
    criteria = registration.ICPConvergenceCriteria(
        relative_fitness=1e-6, relative_rmse=1e-6, max_iteration=100
    )
    call, estimation, distance_m, normals = {
        "point_to_point": (
            registration.registration_icp,
            registration.TransformationEstimationPointToPoint(),
            0.5,
            (False, False),
        ),
        "point_to_plane": (
            registration.registration_icp,
            registration.TransformationEstimationPointToPlane(),
            0.5,
            (True, False),
        ),
        "generalized": (
            registration.registration_generalized_icp,
            registration.TransformationEstimationForGeneralizedICP(),
            1.0,
            (True, True),
        ),
    }[name]

    def match(target, source, guess):
        start = np.eye(4)
        start[:2, :2] = [
            [np.cos(guess[2]), -np.sin(guess[2])],
            [np.sin(guess[2]), np.cos(guess[2])],
        ]
        start[:2, 3] = guess[:2]
        result = call(
            cloud_of(open3d, source, normals[1]),
            cloud_of(open3d, target, normals[0]),
            distance_m,
            start,
            estimation,
            criteria,
        )
        pose = result.transformation
        return pose[0, 3], pose[1, 3], np.arctan2(pose[1, 0], pose[0, 0])

    return match


def main():
    if len(sys.argv) != 4:
        print("point_to_point\npoint_to_plane\ngeneralized")
        return
    path, name, count = sys.argv[1], sys.argv[2], int(sys.argv[3])
    import open3d

    open3d.utility.set_verbosity_level(open3d.utility.VerbosityLevel.Error)
    match = matcher(open3d, name)
    pairs = read_pairs(path)
    chosen = (
        [i * len(pairs) // count for i in range(count)] if count < len(pairs) else range(len(pairs))
    )
    for _ in range(3):
        match(pairs[0][2], pairs[0][3], pairs[0][1])
    for number in chosen:
        _, guess, target, source = pairs[number]
        start = time.process_time()
        x, y, yaw = match(target, source, guess)
        took = time.process_time() - start
        print(f"{number} {x:.9g} {y:.9g} {yaw:.9g} 1 {1e3 * took:.6f}")


if __name__ == "__main__":
    main()
