#include "loopstone/graph/pose_graph.hpp"

#include <cmath>
#include <numeric>
#include <string>

#include "loopstone/base/error.hpp"

namespace loopstone {

namespace {

[[noreturn]] void refuse(std::size_t edge_index, const RelativePoseEdge& edge,
                         const std::string& why) {
  throw UsageError("edge " + std::to_string(edge_index) + " (" + std::to_string(edge.from.index) +
                   " -> " + std::to_string(edge.to.index) + "): " + why);
}

/// By the leading minors (Sylvester).
bool is_positive_definite(const Eigen::Matrix3d& m) {
  const double minor2 = m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
  const double minor3 = m(0, 0) * (m(1, 1) * m(2, 2) - m(1, 2) * m(2, 1)) -
                        m(0, 1) * (m(1, 0) * m(2, 2) - m(1, 2) * m(2, 0)) +
                        m(0, 2) * (m(1, 0) * m(2, 1) - m(1, 1) * m(2, 0));
  return m(0, 0) > 0.0 && minor2 > 0.0 && minor3 > 0.0;
}

bool is_symmetric(const Eigen::Matrix3d& m) {
  const double tolerance = 1e-9 * m.cwiseAbs().maxCoeff();
  return (m - m.transpose()).cwiseAbs().maxCoeff() <= tolerance;
}

}  // namespace

Eigen::Vector3d edge_error(const RelativePoseEdge& edge, const Pose2& from, const Pose2& to) {
  return (edge.from_T_to.inverse() * (from.inverse() * to)).vector();
}

EdgeJacobians edge_jacobians(const RelativePoseEdge& edge, const Pose2& from, const Pose2& to) {
  // e = [Rz^T (Rf^T (t_to - t_from) - t_z); yaw_to - yaw_from - yaw_z], with d(R^T)/dyaw = -R^T S,
  // S = [0 -1; 1 0]. Grisetti et al. 2010, "A tutorial on graph-based SLAM", section IV.
  const double angle = from.yaw + edge.from_T_to.yaw;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  EdgeJacobians result;
  result.from << -c, -s, -s * dx + c * dy,  //
      s, -c, -c * dx - s * dy,              //
      0.0, 0.0, -1.0;
  result.to << c, s, 0.0,  //
      -s, c, 0.0,          //
      0.0, 0.0, 1.0;
  return result;
}

double edge_chi2(const RelativePoseEdge& edge, const Pose2& from, const Pose2& to) {
  const Eigen::Vector3d error = edge_error(edge, from, to);
  return error.dot(edge.information * error);
}

double graph_cost(const PoseGraph& graph) {
  double cost = 0.0;
  for (const RelativePoseEdge& edge : graph.edges) {
    cost += edge_chi2(edge, graph.poses[static_cast<std::size_t>(edge.from.index)],
                      graph.poses[static_cast<std::size_t>(edge.to.index)]);
  }
  return cost;
}

void check_graph(const PoseGraph& graph) {
  const int nodes = static_cast<int>(graph.poses.size());
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    if (!graph.poses[i].vector().allFinite()) {
      throw UsageError("node " + std::to_string(i) + ": its pose is not finite");
    }
  }
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const RelativePoseEdge& edge = graph.edges[i];
    const auto exists = [nodes](NodeId node) { return node.index >= 0 && node.index < nodes; };
    if (!exists(edge.from) || !exists(edge.to)) refuse(i, edge, "joins a node that does not exist");
    if (edge.from == edge.to) refuse(i, edge, "joins a node to itself");
    if (!edge.from_T_to.vector().allFinite()) refuse(i, edge, "its measurement is not finite");
    if (!edge.information.allFinite()) refuse(i, edge, "its information is not finite");
    if (!is_symmetric(edge.information)) refuse(i, edge, "its information is not symmetric");
    if (!is_positive_definite(edge.information)) {
      refuse(i, edge, "its information is not positive definite");
    }
  }
}

GraphComponents connected_components(const PoseGraph& graph) {
  // Union-find with path halving; the lowest node is the root.
  std::vector<int> root(graph.poses.size());
  std::iota(root.begin(), root.end(), 0);
  const auto root_of = [&root](int node) {
    while (root[static_cast<std::size_t>(node)] != node) {
      int& up = root[static_cast<std::size_t>(node)];
      up = root[static_cast<std::size_t>(up)];
      node = up;
    }
    return node;
  };
  for (const RelativePoseEdge& edge : graph.edges) {
    const int a = root_of(edge.from.index);
    const int b = root_of(edge.to.index);
    root[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
  GraphComponents result;
  result.of_node.resize(graph.poses.size());
  for (std::size_t node = 0; node < graph.poses.size(); ++node) {
    const int r = root_of(static_cast<int>(node));
    result.of_node[node] =
        r == static_cast<int>(node) ? result.count++ : result.of_node[static_cast<std::size_t>(r)];
  }
  return result;
}

}  // namespace loopstone
