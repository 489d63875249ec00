"""The same by other packages, where they are installed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loopstone as ls


def test_evo_measures_the_same_errors(result: ls.MapResult, drive: ls.Simulation) -> None:
    metrics = pytest.importorskip("evo.core.metrics")
    estimate, truth = result.trajectory.to_evo(), drive.truth.to_evo()
    estimate.align(truth)
    ours = ls.evaluate(result, drive.truth, rpe_delta=5, rpe_unit="frames")

    ape = metrics.APE(metrics.PoseRelation.translation_part)
    ape.process_data((truth, estimate))
    theirs = ape.get_all_statistics()
    assert ours.ate_translation_m.rmse == pytest.approx(theirs["rmse"], abs=1e-9)
    assert ours.ate_translation_m.mean == pytest.approx(theirs["mean"], abs=1e-9)
    assert ours.ate_translation_m.max == pytest.approx(theirs["max"], abs=1e-9)
    ape = metrics.APE(metrics.PoseRelation.rotation_angle_rad)
    ape.process_data((truth, estimate))
    assert ours.ate_rotation_rad.rmse == pytest.approx(ape.get_all_statistics()["rmse"], abs=1e-7)
    for relation, statistics in (
        (metrics.PoseRelation.translation_part, ours.rpe_translation_m),
        (metrics.PoseRelation.rotation_angle_rad, ours.rpe_rotation_rad),
    ):
        rpe = metrics.RPE(relation, delta=5, delta_unit=metrics.Unit.frames, all_pairs=True)
        rpe.process_data((truth, estimate))
        # evo takes the angle from a matrix, which holds small ones to 1e-8.
        bound = 1e-9 if statistics is ours.rpe_translation_m else 1e-7
        assert statistics.rmse == pytest.approx(rpe.get_all_statistics()["rmse"], abs=bound)


def test_gtsam_finds_the_same_optimum(drive: ls.Simulation) -> None:
    gtsam = pytest.importorskip("gtsam")
    rng = np.random.default_rng(0)
    truth = drive.truth.poses[::5]
    edges = [(i, i + 1) for i in range(len(truth) - 1)]
    edges += [(i, j) for i in range(0, len(truth) - 10, 7) for j in (i + 5, i + 10)]

    def between(a: Any, b: Any) -> Any:
        c, s = np.cos(a[2]), np.sin(a[2])
        d = b - a
        return np.array([c * d[0] + s * d[1], -s * d[0] + c * d[1], d[2]])

    sigmas = np.array([0.03, 0.03, 0.01])
    measured = [between(truth[i], truth[j]) + rng.normal(scale=sigmas) for i, j in edges]
    start = np.array(truth) + rng.normal(scale=0.05, size=truth.shape)
    start[0] = truth[0]
    graph = ls.PoseGraph(start, np.array(edges), measured, np.diag(sigmas**-2))
    ours = ls.optimize(graph, certify=False)
    factors, values = graph.to_gtsam()
    found = gtsam.LevenbergMarquardtOptimizer(factors, values).optimize()
    theirs = np.array(
        [(p.x(), p.y(), p.theta()) for p in (found.atPose2(i) for i in range(len(truth)))]
    )
    # GTSAM's error is half of ours, and that of its chart, which agrees to first order.
    assert ours.cost == pytest.approx(2.0 * factors.error(found), rel=1e-3)
    np.testing.assert_allclose(ours.poses[:, :2], theirs[:, :2], atol=1e-3)


def test_small_gicp_finds_the_same_motion() -> None:
    small_gicp = pytest.importorskip("small_gicp")
    rng = np.random.default_rng(4)
    walls = []
    for axis, level in ((0, -3.0), (0, 3.0), (1, -2.0), (1, 2.5), (2, 0.0), (2, 2.2)):
        points = rng.uniform([-3, -2, 0], [3, 2.5, 2.2], (1500, 3))
        points[:, axis] = level
        walls.append(points)
    box = rng.uniform(0, 1, (1500, 3)) * [0.8, 0.5, 1.0]
    box[:500, 0], box[500:1000, 1], box[1000:, 2] = 0.8, 0.5, 1.0
    target = np.vstack([*walls, box]) + rng.normal(scale=0.003, size=(10500, 3))
    c, s = np.cos(0.05), np.sin(0.05)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    shift = np.array([0.08, -0.06, 0.03])
    source = (target - shift) @ rotation
    theirs = small_gicp.align(
        target, source, registration_type="GICP", downsampling_resolution=0.1
    ).T_target_source
    ours = ls.match(source, target, method="gicp", guess=np.eye(4)).matrix
    np.testing.assert_allclose(ours, theirs, atol=5e-3)
    np.testing.assert_allclose(ours[:3, 3], shift, atol=5e-3)


def test_rosbags_reads_the_same_scans(drive: ls.Simulation, tmp_path: Path) -> None:
    highlevel = pytest.importorskip("rosbags.highlevel")
    typesys = pytest.importorskip("rosbags.typesys")
    drive.save(tmp_path / "drive.bag", "bag")
    ours = [m for m in ls.open_log(tmp_path / "drive.bag") if isinstance(m, ls.LaserScan)]
    store = typesys.get_typestore(typesys.Stores.ROS1_NOETIC)
    with highlevel.AnyReader([tmp_path / "drive.bag"], default_typestore=store) as reader:
        connections = [c for c in reader.connections if c.msgtype.endswith("LaserScan")]
        theirs = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages(connections)]
    assert len(ours) == len(theirs) == drive.scans
    for our, their in zip(ours, theirs):
        stamp = their.header.stamp
        assert our.stamp_ns == stamp.sec * 10**9 + stamp.nanosec
        np.testing.assert_array_equal(our.ranges_m, their.ranges)


def test_mcap_reads_the_same_topics(drive: ls.Simulation, tmp_path: Path) -> None:
    reading = pytest.importorskip("mcap.reader")
    drive.save(tmp_path / "drive.mcap", "mcap")
    with open(tmp_path / "drive.mcap", "rb") as stream:
        counts: dict[str, int] = {}
        for schema, _, _ in reading.make_reader(stream).iter_messages():
            counts[schema.name] = counts.get(schema.name, 0) + 1
    assert counts["sensor_msgs/msg/LaserScan"] == drive.scans
