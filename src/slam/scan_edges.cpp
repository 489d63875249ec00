#include "slam/scan_edges.hpp"

#include <Eigen/LU>
#include <cmath>

#include "loopstone/geometry/covariance.hpp"

namespace loopstone {

namespace {

/// A match farther from the expected motion is not believed.
constexpr double kGateM = 0.5;
constexpr double kGateRad = 0.35;
constexpr double kFloorM = 0.005;
constexpr double kFloorRad = 0.002;
constexpr double kGuessedM = 0.3;
constexpr double kGuessedRad = 0.2;

bool near(const Pose2& pose, const Pose2& expected) {
  const Pose2 off = expected.inverse() * pose;
  return std::hypot(off.x, off.y) <= kGateM && std::abs(off.yaw) <= kGateRad;
}

}  // namespace

Eigen::Matrix3d planar_covariance(double sigma_m, double sigma_rad) {
  return Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad).asDiagonal();
}

PoseWithCovariance2 guessed_motion(const Pose2& last_motion) {
  return {last_motion, planar_covariance(kGuessedM, kGuessedRad)};
}

PoseWithCovariance2 with_floor(PoseWithCovariance2 motion) {
  motion.covariance += planar_covariance(kFloorM, kFloorRad);
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
  const Eigen::Matrix3d information =
      rotated(from_T_to.covariance, from_T_to.pose.rotation().transpose()).inverse();
  return {NodeId{from}, NodeId{to}, from_T_to.pose, 0.5 * (information + information.transpose()),
          kind};
}

}  // namespace loopstone
