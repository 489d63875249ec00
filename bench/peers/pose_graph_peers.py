"""Solves a pose graph with a peer that comes as a Python wheel, for bench/pose_graphs.py.

  pose_graph_peers.py g2o_gauss_newton|gtsam_gauss_newton|gtsam_levenberg_marquardt
                      GRAPH.g2o OPTIMUM [STEPS]

Prints one JSON object: cost (sum of e^T Omega e), seconds of the optimisation alone, steps. The
calls below Python are whole optimisations, so that the language costs nothing.
"""
import json
import sys
import time


class Watch:
    """CPU or wall time since its making, whichever is less: other work on the machine lengthens the
    one, threads the other."""

    def __init__(self):
        self.wall, self.cpu = time.perf_counter(), time.process_time()

    def seconds(self):
        return min(time.perf_counter() - self.wall, time.process_time() - self.cpu)


MOST_STEPS = 30
REACHED = 1e-6


def read_lines(path):
    with open(path, encoding="ascii") as file:
        for line in file:
            words = line.split()
            if words:
                yield words


def g2o_problem(path):
    import g2opy as g2o  # the wheel of g2o's own project
    import numpy as np

    optimizer = g2o.SparseOptimizer()
    solver = g2o.BlockSolverSE2(g2o.LinearSolverEigenSE2())
    optimizer.set_algorithm(g2o.OptimizationAlgorithmGaussNewton(solver))
    vertices = {}
    for words in read_lines(path):
        if words[0] == "VERTEX_SE2":
            vertex = g2o.VertexSE2()
            vertex.set_id(int(words[1]))
            vertex.set_estimate(g2o.SE2(*map(float, words[2:5])))
            if not vertices:
                vertex.set_fixed(True)
            optimizer.add_vertex(vertex)
            vertices[int(words[1])] = vertex
        elif words[0] == "EDGE_SE2":
            edge = g2o.EdgeSE2()
            edge.set_vertex(0, vertices[int(words[1])])
            edge.set_vertex(1, vertices[int(words[2])])
            edge.set_measurement(g2o.SE2(*map(float, words[3:6])))
            u = [float(word) for word in words[6:12]]
            edge.set_information(
                np.array([[u[0], u[1], u[2]], [u[1], u[3], u[4]], [u[2], u[4], u[5]]])
            )
            optimizer.add_edge(edge)
    optimizer.initialize_optimization()
    return optimizer


def g2o_steps(path, optimum):
    """It has no test for convergence, so the number of steps that it needs is found by trial."""
    for steps in range(1, MOST_STEPS + 1):
        trial = g2o_problem(path)
        trial.optimize(steps)
        trial.compute_active_errors()
        if trial.active_chi2() <= optimum * (1 + REACHED):
            return steps
    return MOST_STEPS


def g2o_gauss_newton(path, optimum, steps=None):
    # Whoever measures the process tells the number, so that no trial is in it.
    steps = steps or g2o_steps(path, optimum)
    optimizer = g2o_problem(path)
    watch = Watch()
    optimizer.optimize(steps)
    seconds = watch.seconds()
    optimizer.compute_active_errors()
    return {"cost": optimizer.active_chi2(), "seconds": seconds, "steps": steps}


def gtsam_problem(path):
    import gtsam
    import numpy as np

    graph = gtsam.NonlinearFactorGraph()
    values = gtsam.Values()
    for words in read_lines(path):
        if words[0] == "VERTEX_SE2":
            pose = gtsam.Pose2(*map(float, words[2:5]))
            if values.size() == 0:
                graph.add(gtsam.NonlinearEqualityPose2(int(words[1]), pose))
            values.insert(int(words[1]), pose)
        elif words[0] == "EDGE_SE2":
            u = [float(word) for word in words[6:12]]
            information = np.array([[u[0], u[1], u[2]], [u[1], u[3], u[4]], [u[2], u[4], u[5]]])
            graph.add(
                gtsam.BetweenFactorPose2(
                    int(words[1]),
                    int(words[2]),
                    gtsam.Pose2(*map(float, words[3:6])),
                    gtsam.noiseModel.Gaussian.Information(information),
                )
            )
    return graph, values


def cost_of(path, pose_of):
    """Sum of e^T Omega e with g2o's error: GTSAM's own error takes a logarithm that differs a
    little."""
    import math

    total = 0.0
    for words in read_lines(path):
        if words[0] != "EDGE_SE2":
            continue
        a, b = pose_of(int(words[1])), pose_of(int(words[2]))
        x, y, yaw = map(float, words[3:6])
        c, s = math.cos(a[2] + yaw), math.sin(a[2] + yaw)
        dx, dy = b[0] - a[0], b[1] - a[1]
        e = [
            c * dx + s * dy - (math.cos(yaw) * x + math.sin(yaw) * y),
            -s * dx + c * dy - (-math.sin(yaw) * x + math.cos(yaw) * y),
            math.remainder(b[2] - a[2] - yaw, 2 * math.pi),
        ]
        u = [float(word) for word in words[6:12]]
        total += (
            u[0] * e[0] * e[0]
            + u[3] * e[1] * e[1]
            + u[5] * e[2] * e[2]
            + 2 * (u[1] * e[0] * e[1] + u[2] * e[0] * e[2] + u[4] * e[1] * e[2])
        )
    return total


def gtsam_solve(path, parameters, optimizer_of):
    graph, values = gtsam_problem(path)
    parameters.setMaxIterations(100)
    parameters.setRelativeErrorTol(1e-7)
    parameters.setAbsoluteErrorTol(1e-9)
    watch = Watch()
    optimizer = optimizer_of(graph, values, parameters)
    result = optimizer.optimize()
    seconds = watch.seconds()

    def pose_of(key):
        pose = result.atPose2(key)
        return pose.x(), pose.y(), pose.theta()

    return {"cost": cost_of(path, pose_of), "seconds": seconds, "steps": optimizer.iterations()}


def gtsam_gauss_newton(path, *_):
    import gtsam

    return gtsam_solve(path, gtsam.GaussNewtonParams(), gtsam.GaussNewtonOptimizer)


def gtsam_levenberg_marquardt(path, *_):
    import gtsam

    return gtsam_solve(path, gtsam.LevenbergMarquardtParams(), gtsam.LevenbergMarquardtOptimizer)


PEERS = {
    peer.__name__: peer
    for peer in [g2o_gauss_newton, gtsam_gauss_newton, gtsam_levenberg_marquardt]
}

if __name__ == "__main__":
    print(json.dumps(PEERS[sys.argv[1]](sys.argv[2], float(sys.argv[3]), *map(int, sys.argv[4:]))))
