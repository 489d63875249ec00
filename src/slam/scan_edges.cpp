#include "slam/scan_edges.hpp"

#include <Eigen/LU>
#include <cmath>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/geometry/covariance.hpp"

namespace loopstone {

namespace {

bool near(const Pose2& pose, const Pose2& expected) {
  const Pose2 off = expected.inverse() * pose;
  return hypotenuse(off.x, off.y) <= kScanEdges.gate_m && std::abs(off.yaw) <= kScanEdges.gate_rad;
}

}  // namespace

Eigen::Matrix3d planar_covariance(double sigma_m, double sigma_rad) {
  return Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad).asDiagonal();
}

PoseWithCovariance2 guessed_motion(const Pose2& last_motion) {
  return {last_motion, planar_covariance(kScanEdges.guessed_m, kScanEdges.guessed_rad)};
}

PoseWithCovariance2 with_floor(PoseWithCovariance2 motion) {
  motion.covariance += planar_covariance(kScanEdges.floor_m, kScanEdges.floor_rad);
  return motion;
}

std::optional<PoseWithCovariance2> believed(const MatchResult& match,
                                            const PoseWithCovariance2& expected) {
  if (!has_supported_pose(match.status) || !near(match.target_T_source, expected.pose))
    return std::nullopt;
  PoseWithCovariance2 result = with_floor({match.target_T_source, match.covariance});
  if (match.status == MatchStatus::kDegenerate) {
    const Eigen::Matrix3d wide = with_floor(expected).covariance;
    result.covariance = (result.covariance.inverse() + wide.inverse()).inverse();
  }
  return result;
}

RelativePoseEdge edge_between(int from, int to, const PoseWithCovariance2& from_T_to,
                              EdgeKind kind) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = from_T_to.pose.rotation().transpose();
  const Eigen::Matrix3d information = (turn * from_T_to.covariance * turn.transpose()).inverse();
  return {NodeId{from}, NodeId{to}, from_T_to.pose, 0.5 * (information + information.transpose()),
          kind};
}

}  // namespace loopstone
