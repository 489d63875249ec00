"""To the classes of other packages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import networkx
    import pandas

    from ._core import PoseGraph, Trajectory


def needed(package: str, extra: str) -> ImportError:
    """What is said when a package of an extra is missing."""
    return ImportError(f"this needs {package}: pip install 'loopstone[{extra}]'")


def trajectory_to_pandas(trajectory: Trajectory) -> pandas.DataFrame:
    try:
        import pandas as pd
    except ImportError as error:
        raise needed("pandas", "pandas") from error
    poses = trajectory.poses
    return pd.DataFrame(
        {"x_m": poses[:, 0], "y_m": poses[:, 1], "yaw_rad": poses[:, 2]},
        index=pd.Index(trajectory.stamps_ns, name="stamp_ns"),
    )


def trajectory_to_evo(trajectory: Trajectory) -> Any:
    try:
        from evo.core.trajectory import PoseTrajectory3D
    except ImportError as error:
        raise ImportError("this needs evo: pip install evo (GPL-3)") from error
    import numpy as np

    poses = trajectory.poses
    zero = np.zeros(len(poses))
    return PoseTrajectory3D(
        positions_xyz=np.column_stack([poses[:, :2], zero]),
        orientations_quat_wxyz=np.column_stack(
            [np.cos(poses[:, 2] / 2), zero, zero, np.sin(poses[:, 2] / 2)]
        ),
        timestamps=trajectory.t,
    )


def graph_to_networkx(graph: PoseGraph) -> networkx.MultiDiGraph[int]:
    try:
        import networkx as nx
    except ImportError as error:
        raise needed("networkx", "networkx") from error
    made: networkx.MultiDiGraph[int] = nx.MultiDiGraph()
    for node, pose in enumerate(graph.poses):
        made.add_node(node, pose=tuple(float(v) for v in pose))
    rows = zip(graph.edges, graph.measurements, graph.information, graph.kinds)
    for (i, j), measurement, information, kind in rows:
        made.add_edge(int(i), int(j), measurement=measurement, information=information, kind=kind)
    return made


def graph_to_gtsam(graph: PoseGraph) -> tuple[Any, Any]:
    try:
        import gtsam
    except ImportError as error:
        raise needed("gtsam", "gtsam") from error
    import numpy as np

    factors = gtsam.NonlinearFactorGraph()
    values = gtsam.Values()
    for node, (x, y, yaw) in enumerate(graph.poses):
        values.insert(node, gtsam.Pose2(float(x), float(y), float(yaw)))
    held = graph.fixed or [0]
    tight = gtsam.noiseModel.Diagonal.Sigmas(np.full(3, 1e-9))
    for node in held:
        factors.add(gtsam.PriorFactorPose2(node, values.atPose2(node), tight))
    for (i, j), measured, information in zip(graph.edges, graph.measurements, graph.information):
        factors.add(
            gtsam.BetweenFactorPose2(
                int(i),
                int(j),
                gtsam.Pose2(*(float(v) for v in measured)),
                gtsam.noiseModel.Gaussian.Information(information),
            )
        )
    return factors, values
