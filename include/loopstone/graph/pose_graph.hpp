#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstddef>
#include <vector>

#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// Position of a node in PoseGraph::poses; the ids of a file are kept by its reader.
struct NodeId {
  int index = 0;
  friend constexpr auto operator<=>(const NodeId&, const NodeId&) = default;
};

enum class EdgeKind {
  kOdometry,     ///< between consecutive key scans, from dead reckoning
  kMatch,        ///< a scan aligned to the surroundings it was recorded in
  kLoopClosure,  ///< a place seen again
};

/// A measured relative pose. Error in g2o's convention: e = vector(from_T_to^-1 * (pose_from^-1 * pose_to)), so the
/// translation part is rotated by R(measurement)^T; chi2 = e^T information e.
struct RelativePoseEdge {
  NodeId from;
  NodeId to;
  Pose2 from_T_to;
  Eigen::Matrix3d information =
      Eigen::Matrix3d::Identity();  ///< of (x, y, yaw), symmetric positive definite
  EdgeKind kind = EdgeKind::kMatch;
};

/// Poses to estimate, and what was measured between them. The first pose is held fixed (the gauge).
struct PoseGraph {
  std::vector<Pose2> poses;  ///< map_T_node
  std::vector<RelativePoseEdge> edges;
};

/// e of the definition above.
[[nodiscard]] Eigen::Vector3d edge_error(const RelativePoseEdge& edge, const Pose2& from,
                                         const Pose2& to);

/// Derivatives of edge_error with respect to the coordinates (x, y, yaw) of the two poses.
struct EdgeJacobians {
  Eigen::Matrix3d from;
  Eigen::Matrix3d to;
};
[[nodiscard]] EdgeJacobians edge_jacobians(const RelativePoseEdge& edge, const Pose2& from,
                                           const Pose2& to);

/// e^T information e of one edge.
[[nodiscard]] double edge_chi2(const RelativePoseEdge& edge, const Pose2& from, const Pose2& to);

/// Sum of e^T information e over all edges (no 1/2).
[[nodiscard]] double graph_cost(const PoseGraph& graph);

/// Throws UsageError naming the first edge that joins a node to itself or to one that does not exist, whose
/// measurement is not finite, or whose information is not symmetric positive definite.
void check_graph(const PoseGraph& graph);

/// Which connected component each node belongs to, numbered by their lowest node.
struct GraphComponents {
  std::vector<int> of_node;
  int count = 0;
};
[[nodiscard]] GraphComponents connected_components(const PoseGraph& graph);

}  // namespace loopstone
