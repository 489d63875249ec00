from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loopstone as ls


def square(false_closure: bool = False) -> ls.PoseGraph:
    """A drive round a square by odometry that drifts, and the closure that puts it right."""
    steps = [np.array([1.005, 0.0, np.pi / 2 if i % 10 == 9 else 0.0]) for i in range(40)]
    poses = [np.zeros(3)]
    for step in steps:
        x, y, yaw = poses[-1]
        c, s = np.cos(yaw), np.sin(yaw)
        poses.append(np.array([x + c * step[0], y + s * step[0], yaw + step[2] + 0.002]))
    edges = [(i, i + 1) for i in range(40)] + [(0, 40)]
    measured = [*(s + [0, 0, 0.002] for s in steps), np.zeros(3)]
    if false_closure:
        edges.append((5, 25))
        measured.append(np.array([0.0, 0.0, 0.0]))
    information = np.diag([1000.0, 1000.0, 10000.0])
    return ls.PoseGraph(poses, np.array(edges), measured, information)


def test_a_closure_puts_the_drive_right_and_that_is_proven() -> None:
    graph = square()
    found = ls.optimize(graph)
    assert found.converged and found.cost < found.cost_initial
    assert found.certificate and found.certificate.status == "certified"
    assert np.hypot(*found.poses[-1][:2]) < 0.05
    assert found.graph.cost == pytest.approx(found.cost)
    np.testing.assert_array_equal(found.graph.poses, found.poses)
    assert ls.optimize(graph, certify=False).certificate is None


def test_false_closures_are_told() -> None:
    found = ls.optimize(square(false_closure=True), robust="gnc")
    assert found.edge_weights[-1] == 0.0 and found.edge_weights[-2] == 1.0
    soft = ls.optimize(square(false_closure=True), robust="cauchy")
    assert soft.edge_weights[-1] < 0.1


def test_a_certificate_says_of_what_it_is() -> None:
    whole = ls.optimize(square()).certificate
    assert whole and whole.whole_graph and whole.edges == 41 and whole.edges_set_aside == 0
    assert repr(whole) == "<Certificate: certified>"
    part = ls.optimize(square(false_closure=True), robust="gnc").certificate
    assert part and not part.whole_graph
    assert (part.edges, part.edges_set_aside, part.loop_closures_set_aside) == (41, 1, 1)
    assert "of 41 edges alone: 1 set aside, 1 of them loop closures" in repr(part)


def test_a_kernel_that_turns_down_true_closures_is_told() -> None:
    """A chain that bends far: at its start every closure looks wrong, and DCS believes none."""
    steps = np.tile([1.0, 0.0, 0.0], (90, 1))
    poses = [np.zeros(3)]
    for step in steps:
        x, y, yaw = poses[-1]
        poses.append(np.array([x + np.cos(yaw) * step[0], y + np.sin(yaw) * step[0], yaw + 0.2]))
    truth = np.column_stack([np.arange(91.0), np.zeros(91), np.zeros(91)])
    edges = [(i, i + 1) for i in range(90)] + [(i, i + 20) for i in range(0, 70)]
    odometry = [np.array([1.0, 0.0, 0.2])] * 90
    closures = [truth[i + 20] - truth[i] for i in range(0, 70)]
    information = np.concatenate(
        [
            np.tile(np.diag([1e6, 1e6, 1e8]), (90, 1, 1)),
            np.tile(np.diag([1e4, 1e4, 1e4]), (70, 1, 1)),
        ]
    )
    graph = ls.PoseGraph(np.array(poses), np.array(edges), odometry + closures, information)
    found = ls.optimize(graph, robust="dcs", initial="odometry").certificate
    assert found is not None and not found.whole_graph
    assert found.loop_closures_set_aside > 60 and found.edges < 100
    assert f"{found.loop_closures_set_aside} of them loop closures" in repr(found)


def test_files_keep_every_number(tmp_path: Path) -> None:
    graph = square()
    graph.save(tmp_path / "graph.g2o")
    assert (tmp_path / "graph.g2o").read_text() == graph.to_g2o()
    read = ls.read_graph(tmp_path / "graph.g2o")
    np.testing.assert_array_equal(read.poses, graph.poses)
    np.testing.assert_array_equal(read.edges, graph.edges)
    np.testing.assert_array_equal(read.measurements, graph.measurements)
    np.testing.assert_array_equal(read.information, graph.information)
    assert read.kinds == graph.kinds


def test_the_program_finds_the_same(tmp_path: Path, run: Any) -> None:
    square().save(tmp_path / "in.g2o")
    run("optimize", tmp_path / "in.g2o", "-o", tmp_path / "out.g2o", "--certify", "--quiet")
    ls.optimize(tmp_path / "in.g2o").graph.save(tmp_path / "ours.g2o")
    assert (tmp_path / "ours.g2o").read_bytes() == (tmp_path / "out.g2o").read_bytes()


def test_a_map_is_a_graph_too(result: ls.MapResult) -> None:
    graph = result.graph
    assert graph.edges.shape == (len(graph.kinds), 2)
    assert graph.cost == pytest.approx(result.summary["graph_cost"])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"edges": np.array([[0, 7]])}, "there is no node 7 among 2 poses"),
        ({"edges": np.array([[-1, 1]])}, "there is no node -1"),
        ({"measurements": [[0.0, 0.0]]}, r"measurements: expected an array of shape \(N, 3\)"),
        ({"measurements": [[0.0, 0.0, np.inf]]}, "measurements: must hold finite numbers"),
        ({"measurements": np.zeros((2, 3))}, "as many of one as of the other"),
        ({"information": np.eye(2)}, "information: expected"),
        ({"information": -np.eye(3)}, "positive definite"),
        ({"kinds": ["wheels"]}, "'wheels' is none of"),
        ({"kinds": []}, "kinds: there must be one for each edge"),
        ({"fixed": [9]}, "fixed: there is no node 9"),
        ({"poses": [[0.0, 0.0, 0.0], [np.nan, 0.0, 0.0]]}, "poses: must hold finite numbers"),
    ],
)
def test_what_is_no_graph_is_refused(change: dict[str, Any], words: str) -> None:
    good: dict[str, Any] = {
        "poses": np.zeros((2, 3)),
        "edges": np.array([[0, 1]]),
        "measurements": [[1.0, 0.0, 0.0]],
        "information": np.eye(3),
    }
    ls.PoseGraph(**good)
    with pytest.raises(ValueError, match=words):
        ls.PoseGraph(**{**good, **change})


def test_a_damaged_file_names_its_line(tmp_path: Path) -> None:
    path = tmp_path / "graph.g2o"
    path.write_text("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 0 0\n")
    with pytest.raises(ls.DataError) as caught:
        ls.optimize(path)
    assert caught.value.line == 2
    with pytest.raises(ls.UsageError, match="initial = nowhere"):
        ls.optimize(square(), initial="nowhere")  # type: ignore[arg-type]
    with pytest.raises(ls.OptionsError, match="robust_kernel"):
        ls.optimize(square(), robust="l3")  # type: ignore[arg-type]
