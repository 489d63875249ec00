#include "graph.hpp"

#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/g2o.hpp"
#include "loopstone/formats/machine_memory.hpp"
#include "loopstone/graph/optimize_graph.hpp"
#include "methods.hpp"
#include "options.hpp"
#include "path_like.hpp"
#include "work.hpp"

namespace loopstone::python {

Graph whole_graph(std::shared_ptr<const PoseGraph> graph) {
  Graph whole;
  whole.graph = std::move(graph);
  return whole;
}

namespace {

NodeId node_of(std::int64_t index, std::size_t poses, const char* name) {
  if (index < 0 || static_cast<std::size_t>(index) >= poses) {
    throw nb::value_error((std::string(name) + ": there is no node " + std::to_string(index) +
                           " among " + std::to_string(poses) + " poses")
                              .c_str());
  }
  return NodeId{static_cast<int>(index)};
}

Eigen::Matrix3d information_of(const Numbers& numbers, std::size_t edge) {
  const std::size_t at = numbers.shape.size() == 2 ? 0 : 9 * edge;
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  return Eigen::Map<const RowMajor>(&numbers.values[at]);
}

EdgeKind kind_of(const std::string& word) {
  if (const auto kind = find_word<EdgeKind>(word)) return *kind;
  throw UsageError("kinds: '" + word + "' is none of odometry, match, loop_closure");
}

PoseGraph make_graph(const ArrayLike& poses, const ArrayLike& edges, const ArrayLike& measurements,
                     const ArrayLike& information,
                     const std::optional<std::vector<std::string>>& kinds,
                     const std::vector<std::int64_t>& fixed) {
  PoseGraph graph;
  graph.poses = poses_of(poses, "poses");
  const std::vector<Pose2> measured = poses_of(measurements, "measurements");
  const Integers pairs = integers_of(edges, "edges");
  if (pairs.shape.size() != 2 || pairs.shape[1] != 2)
    throw nb::value_error("edges: expected an array of shape (E, 2)");
  const std::size_t count = pairs.shape[0];
  if (measured.size() != count)
    throw nb::value_error("edges and measurements: there must be as many of one as of the other");
  const Numbers weights = numbers_of(information, "information");
  const bool is_one = weights.shape == std::vector<std::size_t>{3, 3};
  if (!is_one && weights.shape != std::vector<std::size_t>{count, 3, 3})
    throw nb::value_error("information: expected an array of shape (3, 3) or (E, 3, 3)");
  if (kinds && kinds->size() != count)
    throw nb::value_error("kinds: there must be one for each edge");
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t from = pairs.values[2 * i];
    const std::int64_t to = pairs.values[2 * i + 1];
    RelativePoseEdge edge{node_of(from, graph.poses.size(), "edges"),
                          node_of(to, graph.poses.size(), "edges"), measured[i]};
    edge.information = information_of(weights, i);
    edge.kind = to - from == 1 ? EdgeKind::kOdometry : EdgeKind::kLoopClosure;
    if (kinds) edge.kind = kind_of((*kinds)[i]);
    graph.edges.push_back(edge);
  }
  for (const std::int64_t node : fixed)
    graph.fixed.push_back(node_of(node, graph.poses.size(), "fixed"));
  check_graph(graph);
  return graph;
}

Array<std::int64_t, nb::ndim<2>> edges_of(const Graph& self) {
  std::vector<std::int64_t> pairs;
  for (const RelativePoseEdge& edge : self.graph->edges)
    pairs.insert(pairs.end(), {edge.from.index, edge.to.index});
  return array_of<std::int64_t, nb::ndim<2>>(std::move(pairs), {self.graph->edges.size(), 2});
}

Matrix measurements_of(const Graph& self) {
  std::vector<Pose2> poses;
  for (const RelativePoseEdge& edge : self.graph->edges) poses.push_back(edge.from_T_to);
  return to_array(std::span<const Pose2>(poses));
}

Array<double, nb::ndim<3>> informations_of(const Graph& self) {
  std::vector<double> values;
  for (const RelativePoseEdge& edge : self.graph->edges)
    values.insert(values.end(), edge.information.data(), edge.information.data() + 9);
  return array_of<double, nb::ndim<3>>(std::move(values), {self.graph->edges.size(), 3, 3});
}

std::vector<std::string> kinds_of(const Graph& self) {
  std::vector<std::string> kinds;
  for (const RelativePoseEdge& edge : self.graph->edges)
    kinds.emplace_back(loopstone::to_string(edge.kind));
  return kinds;
}

nb::ndarray<nb::numpy, const double, nb::ro, nb::shape<-1, 3>> poses_view(
    nb::handle_t<Graph> self) {
  static_assert(sizeof(Pose2) == 3 * sizeof(double));
  const auto& poses = nb::cast<const Graph&>(self).graph->poses;
  const double* first = poses.empty() ? nullptr : &poses.front().x;
  return {first, {poses.size(), 3}, self};
}

Graph read_graph(const PathLike& path, const std::string& information_order) {
  const auto order = find_word<InformationOrder>(information_order);
  if (!order) throw UsageError("information_order: must be one of guess, g2o, toro");
  const nb::gil_scoped_release unlocked;
  GraphFile file = read_g2o(path.value, *order, machine_memory_budget());
  require_connected(file, path.value);
  Graph graph;
  graph.graph = std::make_shared<const PoseGraph>(std::move(file.graph));
  graph.ids = std::move(file.ids);
  graph.landmark_ids = std::move(file.landmark_ids);
  graph.has_poses = file.has_poses;
  graph.notes = std::move(file.notes);
  return graph;
}

void write_graph(const Graph& graph, const PathLike& path) {
  const nb::gil_scoped_release unlocked;
  if (graph.ids.empty()) return write_g2o(path.value, *graph.graph);
  GraphFile file;
  file.graph = *graph.graph;
  file.ids = graph.ids;
  file.landmark_ids = graph.landmark_ids;
  write_g2o(path.value, file);
}

void def_parts(nb::class_<Graph>& graph) {
  def_array(graph, "poses", poses_view, "(N, 3) x, y [m], yaw [rad], a read-only view.");
  def_array(graph, "edges", edges_of, "(E, 2) int64 nodes.");
  def_array(graph, "measurements", measurements_of, "(E, 3) pose j in the frame of i.");
  def_array(graph, "information", informations_of, "(E, 3, 3) of x, y, yaw.");
  graph.def_prop_ro("kinds", kinds_of, "``odometry``, ``match`` or ``loop_closure`` of each edge.");
  def_array(
      graph, "landmarks",
      [](const Graph& self) {
        std::vector<double> values;
        for (const Eigen::Vector2d& p : self.graph->landmarks)
          values.insert(values.end(), {p.x(), p.y()});
        return array_of<double, nb::ndim<2>>(std::move(values), {self.graph->landmarks.size(), 2});
      },
      "(L, 2) [m].");
  graph.def_prop_ro(
      "fixed",
      [](const Graph& self) {
        std::vector<int> nodes;
        for (const NodeId node : self.graph->fixed) nodes.push_back(node.index);
        return nodes;
      },
      "Held nodes.");
  graph.def_prop_ro(
      "cost", [](const Graph& self) { return graph_cost(*self.graph); },
      "Sum of e^T information e (no 1/2) at the poses.");
}

void bind_pose_graph(nb::module_& m) {
  nb::class_<Graph> graph(
      m, "PoseGraph",
      "Poses to estimate and measurements between them; can't be changed.\n\n"
      "The error of an edge is g2o's, e = vector(measurement^-1 * (pose_i^-1 * pose_j)). Held\n"
      "poses stay; without any, the first pose does.");
  graph.def(
      "__init__",
      [](Graph* self, const ArrayLike& poses, const ArrayLike& edges, const ArrayLike& measurements,
         const ArrayLike& information, const std::optional<std::vector<std::string>>& kinds,
         const std::vector<std::int64_t>& fixed) {
        new (self) Graph(whole_graph(std::make_shared<const PoseGraph>(
            make_graph(poses, edges, measurements, information, kinds, fixed))));
      },
      nb::arg("poses"), nb::arg("edges"), nb::arg("measurements"), nb::arg("information"),
      nb::kw_only(), nb::arg("kinds") = nb::none(), nb::arg("fixed") = std::vector<std::int64_t>{},
      "Copies (N, 3) poses x, y [m], yaw [rad]; (E, 2) int64 nodes i, j from 0; (E, 3) pose j in\n"
      "the frame of i as measured; (E, 3, 3) or one (3, 3) information of x, y, yaw.\n\n"
      ":param kinds: ``odometry``, ``match`` or ``loop_closure`` of each edge; without, edges\n"
      "    from i to i + 1 are odometry and all others loop closures, which robust kernels doubt\n"
      ":param fixed: nodes that stay where they are\n"
      ":raises ValueError: for arrays of other shapes\n"
      ":raises UsageError: naming the edge that makes no sense");
  def_parts(graph);
  graph.def_ro("notes", &Graph::notes, "What was guessed when it was read, in words.");
  graph.def(
      "to_g2o", [](const Graph& self) { return format_g2o(*self.graph); },
      "The text of a g2o file; nodes by their numbers.");
  graph.def("save", write_graph, nb::arg("path"),
            "Writes a g2o file, whole or not at all; nodes have the names they were read with.");
  def_python(graph, "to_networkx", "loopstone._convert", "graph_to_networkx",
             "def to_networkx(self) -> networkx.MultiDiGraph[int]",
             "Nodes with ``pose``, edges with ``measurement``, ``information``, ``kind``. Needs "
             "loopstone[networkx].");
  def_python(graph, "to_gtsam", "loopstone._convert", "graph_to_gtsam",
             "def to_gtsam(self) -> tuple[typing.Any, typing.Any]",
             "(NonlinearFactorGraph, Values): BetweenFactorPose2, the first pose or held ones "
             "by a tight prior. Needs loopstone[gtsam].");
  graph.def("__repr__", [](const Graph& self) {
    return "<PoseGraph of " + std::to_string(self.graph->poses.size()) + " poses and " +
           std::to_string(self.graph->edges.size()) + " edges>";
  });
  m.def("read_graph", read_graph, nb::arg("path"), nb::arg("information_order") = "guess",
        "Reads a pose graph of g2o or TORO. Raises DataError with the line.");
}

/// A solved graph, and how it came to be.
struct Optimised {
  Graph graph{};
  GraphOptimisation found{};
};

Optimised optimise(const Graph& given, const std::string& initial, bool gnc, bool certify,
                   const OptionValues& values) {
  const auto settings = options_of<OptimizeOptions>(values);
  GraphOptimisationOptions options;
  if (!initial.empty()) options.start = find_word<Initialisation>(initial);
  if (!initial.empty() && !options.start)
    throw UsageError("initial = " + initial +
                     ": must be one of file, odometry, spanning_tree, chordal");
  options.poses_given = given.has_poses;
  options.solver = settings.solver;
  if (gnc) options.gnc = settings.gnc;
  if (certify) options.certificate = settings.certificate;
  Optimised result{given, work(nb::none(), [&](Work& own) {
                     options.stop = [&own] { return !own.goes_on(); };
                     return optimize_graph(*given.graph, options);
                   })};
  PoseGraph solved = *given.graph;
  solved.poses = result.found.solved.poses;
  solved.landmarks = result.found.solved.landmarks;
  result.graph.graph = std::make_shared<const PoseGraph>(std::move(solved));
  result.graph.has_poses = true;
  return result;
}

const Certificate* certificate_of(const Optimised& self) {
  return self.found.certified ? &self.found.certified->certificate : nullptr;
}

void bind_certificate(nb::module_& m) {
  nb::class_<Certificate> certificate(
      m, "Certificate",
      "Whether the isotropic objective of SE-Sync is at its global minimum, with the proof.");
  certificate.def_prop_ro("certified", &Certificate::certified,
                          "It is proven, of the edges that it is about; also what bool() tells.");
  certificate.def_prop_ro(
      "status", [](const Certificate& c) { return std::string(loopstone::to_string(c.status)); },
      "``certified``, ``not_optimal``, ``gap_open``, ``not_converged``, "
      "``numerical_failure`` or ``unsupported``.");
  certificate.def_ro("cost", &Certificate::cost, "Of that objective at the poses.");
  certificate.def_ro("lower_bound", &Certificate::lower_bound,
                     "No solution costs less; -inf when nothing is known.");
  certificate.def_ro("optimality_gap", &Certificate::optimality_gap, "cost - lower_bound");
  certificate.def_ro("min_eigenvalue", &Certificate::min_eigenvalue,
                     "Of the dual certificate matrix; at an optimum 0 to rounding.");
  certificate.def_ro("edges", &Certificate::edges, "That it is about.");
  certificate.def_ro(
      "edges_set_aside", &Certificate::edges_set_aside,
      "Edges that a robust kernel turned down before (weight below 0.5). Nothing is\n"
      "proven of them, nor that turning them down was right.");
  certificate.def_ro("loop_closures_set_aside", &Certificate::closures_set_aside,
                     "Of these, loop closures. When it is most of them, what was proven is little\n"
                     "more than that odometry agrees with itself.");
  certificate.def_prop_ro(
      "whole_graph", &Certificate::is_of_whole_graph,
      "It is about every edge; also what a certificate should be asked that is\n"
      "to stand for a map.");
  certificate.def("__bool__", &Certificate::certified);
  certificate.def("__repr__", [](const Certificate& c) {
    std::string text = "<Certificate: " + std::string(loopstone::to_string(c.status));
    if (!c.is_of_whole_graph()) {
      text += fmt::format(", of {} edges alone: {} set aside, {} of them loop closures", c.edges,
                          c.edges_set_aside, c.closures_set_aside);
    }
    return text + ">";
  });
}

void bind_optimised(nb::module_& m) {
  nb::class_<Optimised> result(m, "OptimizeResult",
                               "A solved pose graph; see :func:`loopstone.optimize`.");
  result.def_ro("graph", &Optimised::graph, "At the solution.");
  def_array(
      result, "poses",
      [](const Optimised& self) {
        return to_array(std::span<const Pose2>(self.found.solved.poses));
      },
      "(N, 3) x, y [m], yaw [rad].");
  result.def_prop_ro(
      "status",
      [](const Optimised& self) {
        return std::string(loopstone::to_string(self.found.solved.status));
      },
      "``converged``, ``not_converged``, ``numerical_failure`` or ``disconnected``.");
  result.def_prop_ro(
      "converged",
      [](const Optimised& self) { return self.found.solved.status == SolveStatus::kConverged; },
      "Whether that is the status.");
  result.def_prop_ro(
      "cost_initial", [](const Optimised& self) { return self.found.solved.cost_initial; },
      "Sum of e^T information e at the start, no kernel in it.");
  result.def_prop_ro(
      "cost", [](const Optimised& self) { return self.found.solved.cost; },
      "The same at the solution.");
  result.def_prop_ro(
      "initial",
      [](const Optimised& self) {
        return std::string(loopstone::to_string(self.found.start.initialisation));
      },
      "Where it began: ``file``, ``odometry``, ``spanning_tree`` or ``chordal``.");
  result.def_prop_ro(
      "iterations", [](const Optimised& self) { return self.found.iterations(); },
      "Of all solutions together, those of the certificate included.");
  result.def_prop_ro(
      "wall_time_s", [](const Optimised& self) { return self.found.times.wall_s(); },
      "What it took [s].");
  def_array(
      result, "edge_weights",
      [](const Optimised& self) {
        const std::vector<double>& weights = self.found.solved.edge_weights;
        return array_of<double, nb::ndim<1>>(weights, {weights.size()});
      },
      "(E,) in [0, 1], by the robust kernel; 1 without.");
  result.def_prop_ro("certificate", certificate_of, nb::rv_policy::reference_internal,
                     nb::sig("def certificate(self) -> Certificate | None"),
                     "When it was asked for; of the edges that were kept.");
  result.def("__repr__", [](const Optimised& self) {
    return "<OptimizeResult: " + std::string(loopstone::to_string(self.found.solved.status)) +
           ", cost " + std::to_string(self.found.solved.cost) + ">";
  });
  m.def("optimize", optimise, nb::arg("graph"), nb::arg("initial"), nb::arg("gnc"),
        nb::arg("certify"), nb::arg("options"));
}

}  // namespace

void bind_graph(nb::module_& m) {
  bind_pose_graph(m);
  bind_certificate(m);
  bind_optimised(m);
}

}  // namespace loopstone::python
