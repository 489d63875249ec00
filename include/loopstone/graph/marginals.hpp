#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// How well poses are known, from the curvature of the cost at the graph's poses (solve it first).
struct PoseMarginals {
  bool available =
      false;  ///< false: some pose is not held by any measurement, so nothing can be said
  std::vector<Eigen::Matrix3d>
      covariances;  ///< of (x, y, yaw) in the map frame [m^2, m rad, rad^2]; zero for fixed poses
};

/// Covariances of the chosen poses: diagonal blocks of (J^T information J)^-1 with the gauge of
/// PoseGraph.
/// Cost: about three factorisations, however many poses are asked for. Throws UsageError as
/// check_graph does, and for a pose that does not exist.
[[nodiscard]] PoseMarginals marginal_covariances(const PoseGraph& graph,
                                                 std::span<const NodeId> nodes);

/// Covariances of the chosen landmarks, of (x, y) in the map frame [m^2], as above. Throws
/// UsageError for a landmark that does not exist or that no pose sees.
struct LandmarkMarginals {
  bool available = false;
  std::vector<Eigen::Matrix2d> covariances;
};
[[nodiscard]] LandmarkMarginals landmark_covariances(const PoseGraph& graph,
                                                     std::span<const LandmarkId> landmarks);

/// Of all landmarks together: of (x, y) of the first, of the second and so on, the map frame [m^2].
/// Empty when some pose is not held by any measurement. Cost: a factorisation, and two solutions a
/// landmark. Throws UsageError as check_graph does, and for a landmark that no pose sees.
[[nodiscard]] Eigen::MatrixXd joint_landmark_covariance(const PoseGraph& graph);

/// How well pairs of poses are known together.
struct PairMarginals {
  bool available = false;
  std::vector<Eigen::Matrix<double, 6, 6>> covariances;  ///< of (first, second), the map frame
};
/// As marginal_covariances, of pairs. The same pose twice gives its covariance four times.
[[nodiscard]] PairMarginals joint_covariances(const PoseGraph& graph,
                                              std::span<const std::pair<NodeId, NodeId>> pairs);

/// Covariance of the motion from the first pose of a pair to the second, (x, y, yaw) in the first
/// one's frame, to first order.
[[nodiscard]] Eigen::Matrix3d relative_covariance(const Pose2& first, const Pose2& second,
                                                  const Eigen::Matrix<double, 6, 6>& joint);

}  // namespace loopstone
