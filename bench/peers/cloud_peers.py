#!/usr/bin/env python3
"""small_gicp and Open3D on the partial clouds of UCSD's ICP warm-up: from centroids and 36 turns
about the upright axis, each start run to its end, the best taken by the rmse of every observed
point to its nearest model point. Prints JSON.

  cloud_peers.py FOLDER [--quick]      FOLDER has drill/ and liq_container/: model.mat, 0.npy ...
                                       3.npy
"""
import json
import os
import pathlib
import sys
import time

os.environ["OMP_NUM_THREADS"] = "1"
import numpy as np  # noqa: E402
import scipy.io  # noqa: E402
import scipy.spatial  # noqa: E402

POINTS = 2500  # of the observed cloud, as the reference had it; the rmse takes all of them
METRES = 1e-3  # the models are in millimetres
MAX_DISTANCE_M = 0.1


def thinned(cloud, count):
    step = max(1, len(cloud) // count)
    return np.ascontiguousarray(cloud[::step])


def starts_of(model, observed, count):
    """model_T_observed with the centroids on each other."""
    for i in range(count):
        yaw = 2.0 * np.pi * i / count
        start = np.eye(4)
        start[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
        start[:3, 3] = model.mean(0) - start[:3, :3] @ observed.mean(0)
        yield start


def small_gicp_gicp(model, observed, starts):
    import small_gicp

    target, source = small_gicp.PointCloud(model), small_gicp.PointCloud(observed)
    tree = small_gicp.KdTree(target)
    small_gicp.estimate_covariances(target, tree, 20, 1)
    small_gicp.estimate_covariances(source, small_gicp.KdTree(source), 20, 1)
    options = {
        "registration_type": "GICP",
        "num_threads": 1,
        "max_correspondence_distance": MAX_DISTANCE_M,
        "max_iterations": 100,
        "rotation_epsilon": 1e-5,
        "translation_epsilon": 1e-6,
    }
    return [
        small_gicp.align(
            target, source, tree, init_T_target_source=start, **options
        ).T_target_source
        for start in starts
    ]


def open3d_clouds(model, observed, normals):
    import open3d

    clouds = []
    for points in (model, observed):
        cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
        if normals:
            cloud.estimate_normals(open3d.geometry.KDTreeSearchParamKNN(20))
        clouds.append(cloud)
    return clouds


def open3d_runs(call_name, estimation_name, normals):
    def align(model, observed, starts):
        import open3d

        registration = open3d.pipelines.registration
        target, source = open3d_clouds(model, observed, normals)
        criteria = registration.ICPConvergenceCriteria(max_iteration=60)
        call = getattr(registration, call_name)
        estimation = getattr(registration, estimation_name)()
        return [
            np.asarray(
                call(source, target, MAX_DISTANCE_M, start, estimation, criteria).transformation
            )
            for start in starts
        ]

    return align


PEERS = [
    ("small_gicp GICP", small_gicp_gicp),
    (
        "Open3D point to point",
        open3d_runs("registration_icp", "TransformationEstimationPointToPoint", False),
    ),
    (
        "Open3D point to plane",
        open3d_runs("registration_icp", "TransformationEstimationPointToPlane", True),
    ),
    (
        "Open3D generalized ICP",
        open3d_runs(
            "registration_generalized_icp", "TransformationEstimationForGeneralizedICP", True
        ),
    ),
]


def main():
    folder = pathlib.Path(sys.argv[1])
    quick = "--quick" in sys.argv
    count = 6 if quick else 36
    rows = []
    for thing in ("drill", "liq_container"):
        model = np.asarray(scipy.io.loadmat(folder / thing / "model.mat")["Mdata"], dtype=float)
        model = METRES * np.ascontiguousarray(model if model.shape[1] == 3 else model.T)
        whole_tree = scipy.spatial.cKDTree(model)
        for number in range(1 if quick else 4):
            observed = np.load(folder / thing / f"{number}.npy").astype(float)
            for title, align in PEERS:
                started = time.process_time()
                few = thinned(observed, POINTS)
                poses = align(model, few, list(starts_of(model, few, count)))
                took_s = time.process_time() - started
                errors = []
                for pose in poses:
                    moved = observed @ pose[:3, :3].T + pose[:3, 3]
                    distances, _ = whole_tree.query(moved)
                    errors.append(float(np.sqrt(np.mean(distances**2))))
                best = min(errors)
                rows.append(
                    {
                        "name": f"{thing} {number}",
                        "peer": title,
                        "rmse_mm": 1e3 * best,
                        "starts": count,
                        "near_best": sum(error < 1.1 * best for error in errors),
                        "ms": 1e3 * took_s,
                    }
                )
                print(rows[-1], file=sys.stderr, flush=True)
    print(json.dumps(rows))


if __name__ == "__main__":
    main()
