#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstddef>
#include <vector>

#include "loopstone/base/words.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// Position of a node in PoseGraph::poses; the ids of a file are kept by its reader.
struct NodeId {
  int index = 0;
  friend constexpr auto operator<=>(const NodeId&, const NodeId&) = default;

  template <typename Archive>
  void archive(Archive& a) {
    a(index);
  }
};

enum class EdgeKind {
  kOdometry,     ///< between consecutive key scans, from dead reckoning
  kMatch,        ///< a scan aligned to the surroundings it was recorded in
  kLoopClosure,  ///< a place seen again
};

constexpr auto words_of(EdgeKind /*any*/) {
  using enum EdgeKind;
  return std::array{Word{kOdometry, "odometry"}, Word{kMatch, "match"},
                    Word{kLoopClosure, "loop_closure"}};
}

/// A measured relative pose. Error in g2o's convention: e = vector(from_T_to^-1 * (pose_from^-1 *
/// pose_to)), so the translation part is rotated by R(measurement)^T; chi2 = e^T information e.
struct RelativePoseEdge {
  NodeId from;
  NodeId to;
  Pose2 from_T_to;
  Eigen::Matrix3d information =
      Eigen::Matrix3d::Identity();  ///< of (x, y, yaw), symmetric positive definite
  EdgeKind kind = EdgeKind::kMatch;

  template <typename Archive>
  void archive(Archive& a) {
    a(from, to, from_T_to, information, kind);
  }
};

/// What is known of one pose in the map frame (g2o's EDGE_SE2_PRIOR): e = vector(map_T_node^-1 *
/// pose).
struct PosePrior {
  NodeId node;
  Pose2 map_T_node;
  Eigen::Matrix3d information =
      Eigen::Matrix3d::Identity();  ///< of (x, y, yaw), symmetric positive definite

  template <typename Archive>
  void archive(Archive& a) {
    a(node, map_T_node, information);
  }
};

/// Position of a point in PoseGraph::landmarks.
struct LandmarkId {
  int index = 0;
  friend constexpr auto operator<=>(const LandmarkId&, const LandmarkId&) = default;

  template <typename Archive>
  void archive(Archive& a) {
    a(index);
  }
};

/// A landmark seen from a pose (g2o's EDGE_SE2_XY): e = pose_from^-1 * landmark - measured point.
struct LandmarkEdge {
  NodeId from;
  LandmarkId landmark;
  Eigen::Vector2d point_in_from = Eigen::Vector2d::Zero();  ///< [m]
  Eigen::Matrix2d information = Eigen::Matrix2d::Identity();

  template <typename Archive>
  void archive(Archive& a) {
    a(from, landmark, point_in_from, information);
  }
};

/// Poses and landmarks to estimate, and what was measured between them.
///
/// The gauge: poses in `fixed` stay where they are. A connected component that has none and no
/// prior holds its first pose, since measurements within it say nothing about where it lies.
struct PoseGraph {
  std::vector<Pose2> poses{};  ///< map_T_node
  std::vector<RelativePoseEdge> edges{};
  std::vector<PosePrior> priors{};
  std::vector<Eigen::Vector2d> landmarks{};  ///< in the map frame [m]
  std::vector<LandmarkEdge> landmark_edges{};
  std::vector<NodeId> fixed{};

  template <typename Archive>
  void archive(Archive& a) {
    a(poses, edges, priors, landmarks, landmark_edges, fixed);
  }
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

[[nodiscard]] Eigen::Vector3d prior_error(const PosePrior& prior, const Pose2& pose);
/// Derivative of prior_error with respect to the pose's (x, y, yaw).
[[nodiscard]] Eigen::Matrix3d prior_jacobian(const PosePrior& prior);
[[nodiscard]] double prior_chi2(const PosePrior& prior, const Pose2& pose);

[[nodiscard]] Eigen::Vector2d landmark_error(const LandmarkEdge& edge, const Pose2& from,
                                             const Eigen::Vector2d& landmark);
struct LandmarkJacobians {
  Eigen::Matrix<double, 2, 3> from;
  Eigen::Matrix2d landmark;
};
[[nodiscard]] LandmarkJacobians landmark_jacobians(const Pose2& from,
                                                   const Eigen::Vector2d& landmark);
[[nodiscard]] double landmark_chi2(const LandmarkEdge& edge, const Pose2& from,
                                   const Eigen::Vector2d& landmark);

/// Sum of e^T information e over all edges, priors and landmark edges (no 1/2).
[[nodiscard]] double graph_cost(const PoseGraph& graph);

/// Throws UsageError naming the first edge, prior or landmark edge that joins a node to itself or
/// to one that does not exist, whose measurement is not finite, or whose information is not
/// symmetric positive definite; a pose or landmark that is not finite; a fixed node that does not
/// exist.
void check_graph(const PoseGraph& graph);

/// Which connected component each node belongs to, numbered by their lowest node. A landmark joins
/// the poses that see it; one that no pose sees belongs to none.
struct GraphComponents {
  std::vector<int> of_node;
  int count = 0;
};
[[nodiscard]] GraphComponents connected_components(const PoseGraph& graph);

}  // namespace loopstone
