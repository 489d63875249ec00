#include "loopstone/graph/pose_graph.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/base/union_find.hpp"

namespace loopstone {

namespace {

/// By the leading minors (Sylvester).
bool is_positive_definite(const Eigen::Matrix2d& m) {
  return m(0, 0) > 0.0 && m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0) > 0.0;
}

bool is_positive_definite(const Eigen::Matrix3d& m) {
  const double minor2 = m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
  const double minor3 = m(0, 0) * (m(1, 1) * m(2, 2) - m(1, 2) * m(2, 1)) -
                        m(0, 1) * (m(1, 0) * m(2, 2) - m(1, 2) * m(2, 0)) +
                        m(0, 2) * (m(1, 0) * m(2, 1) - m(1, 1) * m(2, 0));
  return m(0, 0) > 0.0 && minor2 > 0.0 && minor3 > 0.0;
}

template <int N>
bool is_symmetric(const Eigen::Matrix<double, N, N>& m) {
  const double tolerance = 1e-9 * m.cwiseAbs().maxCoeff();
  return (m - m.transpose()).cwiseAbs().maxCoeff() <= tolerance;
}

/// Empty when the information of a measurement can be used.
template <int N>
std::string complaint_about(const Eigen::Matrix<double, N, N>& information) {
  if (!information.allFinite()) return "its information is not finite";
  if (!is_symmetric(information)) return "its information is not symmetric";
  if (!is_positive_definite(information)) return "its information is not positive definite";
  return {};
}

std::string complaint_about(const RelativePoseEdge& edge, int nodes) {
  const auto exists = [nodes](NodeId node) { return node.index >= 0 && node.index < nodes; };
  if (!exists(edge.from) || !exists(edge.to)) return "joins a node that does not exist";
  if (edge.from == edge.to) return "joins a node to itself";
  if (!edge.from_T_to.vector().allFinite()) return "its measurement is not finite";
  return complaint_about(edge.information);
}

std::string complaint_about(const PosePrior& prior, int nodes) {
  if (prior.node.index < 0 || prior.node.index >= nodes)
    return "is about a node that does not exist";
  if (!prior.map_T_node.vector().allFinite()) return "its pose is not finite";
  return complaint_about(prior.information);
}

std::string complaint_about(const LandmarkEdge& edge, int nodes, int landmarks) {
  if (edge.from.index < 0 || edge.from.index >= nodes) return "joins a node that does not exist";
  if (edge.landmark.index < 0 || edge.landmark.index >= landmarks) {
    return "joins a landmark that does not exist";
  }
  if (!edge.point_in_from.allFinite()) return "its measurement is not finite";
  return complaint_about(edge.information);
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

Eigen::Vector3d prior_error(const PosePrior& prior, const Pose2& pose) {
  return (prior.map_T_node.inverse() * pose).vector();
}

Eigen::Matrix3d prior_jacobian(const PosePrior& prior) {
  // e = [Rz^T (t - t_z); yaw - yaw_z].
  Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
  result.topLeftCorner<2, 2>() = prior.map_T_node.rotation().transpose();
  return result;
}

double prior_chi2(const PosePrior& prior, const Pose2& pose) {
  const Eigen::Vector3d error = prior_error(prior, pose);
  return error.dot(prior.information * error);
}

Eigen::Vector2d landmark_error(const LandmarkEdge& edge, const Pose2& from,
                               const Eigen::Vector2d& landmark) {
  return from.inverse() * landmark - edge.point_in_from;
}

LandmarkJacobians landmark_jacobians(const Pose2& from, const Eigen::Vector2d& landmark) {
  // e = R^T (l - t) - z, with d(R^T)/dyaw = -R^T S, S = [0 -1; 1 0].
  const double c = std::cos(from.yaw);
  const double s = std::sin(from.yaw);
  const double dx = landmark.x() - from.x;
  const double dy = landmark.y() - from.y;
  LandmarkJacobians result;
  result.from << -c, -s, -s * dx + c * dy,  //
      s, -c, -c * dx - s * dy;
  result.landmark << c, s,  //
      -s, c;
  return result;
}

double landmark_chi2(const LandmarkEdge& edge, const Pose2& from, const Eigen::Vector2d& landmark) {
  const Eigen::Vector2d error = landmark_error(edge, from, landmark);
  return error.dot(edge.information * error);
}

double graph_cost(const PoseGraph& graph) {
  const auto pose = [&graph](NodeId node) -> const Pose2& {
    return graph.poses[static_cast<std::size_t>(node.index)];
  };
  double cost = 0.0;
  for (const RelativePoseEdge& edge : graph.edges) {
    cost += edge_chi2(edge, pose(edge.from), pose(edge.to));
  }
  for (const PosePrior& prior : graph.priors) cost += prior_chi2(prior, pose(prior.node));
  for (const LandmarkEdge& edge : graph.landmark_edges) {
    cost += landmark_chi2(edge, pose(edge.from),
                          graph.landmarks[static_cast<std::size_t>(edge.landmark.index)]);
  }
  return cost;
}

void check_graph(const PoseGraph& graph) {
  const int nodes = static_cast<int>(graph.poses.size());
  const int landmarks = static_cast<int>(graph.landmarks.size());
  const auto refuse = [](const std::string& what, std::size_t index, const std::string& why) {
    throw UsageError(what + ' ' + std::to_string(index) + why);
  };
  const auto ends = [](int from, int to) {
    return " (" + std::to_string(from) + " -> " + std::to_string(to) + "): ";
  };
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    if (!graph.poses[i].vector().allFinite()) refuse("node", i, ": its pose is not finite");
  }
  for (std::size_t i = 0; i < graph.landmarks.size(); ++i) {
    if (!graph.landmarks[i].allFinite()) refuse("landmark", i, ": its position is not finite");
  }
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const RelativePoseEdge& edge = graph.edges[i];
    const std::string why = complaint_about(edge, nodes);
    if (!why.empty()) refuse("edge", i, ends(edge.from.index, edge.to.index) + why);
  }
  for (std::size_t i = 0; i < graph.priors.size(); ++i) {
    const PosePrior& prior = graph.priors[i];
    const std::string why = complaint_about(prior, nodes);
    if (!why.empty())
      refuse("prior", i, " (node " + std::to_string(prior.node.index) + "): " + why);
  }
  for (std::size_t i = 0; i < graph.landmark_edges.size(); ++i) {
    const LandmarkEdge& edge = graph.landmark_edges[i];
    const std::string why = complaint_about(edge, nodes, landmarks);
    if (!why.empty()) {
      refuse("landmark edge", i, ends(edge.from.index, edge.landmark.index) + why);
    }
  }
  for (const NodeId node : graph.fixed) {
    if (node.index < 0 || node.index >= nodes) {
      throw UsageError("fixed node " + std::to_string(node.index) + " does not exist");
    }
  }
}

GraphComponents connected_components(const PoseGraph& graph) {
  // The lowest node of a component is the root.
  std::vector<int> parents(graph.poses.size());
  std::iota(parents.begin(), parents.end(), 0);
  for (const RelativePoseEdge& edge : graph.edges) join(parents, edge.from.index, edge.to.index);
  std::vector<int> first_seen_from(graph.landmarks.size(), -1);
  for (const LandmarkEdge& edge : graph.landmark_edges) {
    int& first = first_seen_from[static_cast<std::size_t>(edge.landmark.index)];
    if (first < 0) first = edge.from.index;
    join(parents, first, edge.from.index);
  }
  GraphComponents result;
  result.of_node.resize(graph.poses.size());
  for (std::size_t node = 0; node < graph.poses.size(); ++node) {
    const int r = root_of(parents, static_cast<int>(node));
    result.of_node[node] =
        r == static_cast<int>(node) ? result.count++ : result.of_node[static_cast<std::size_t>(r)];
  }
  return result;
}

}  // namespace loopstone
