#include "localization/pose_track.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/registration/field_match.hpp"

namespace loopstone {

namespace {

/// Registrations share the map's own errors from scan to scan, so each counts less than its covariance says.
constexpr double kCovarianceFactor = 4.0;
/// What dead reckoning adds at least between two scans.
constexpr double kDriftM = 0.003;
constexpr double kDriftRad = 0.001;
/// A registration farther from the prediction than this (squared Mahalanobis distance, 3 degrees of freedom) is not believed.
constexpr double kGate = 40.0;
/// Share of the newest registration in the mean innovation.
constexpr double kNewest = 0.15;
constexpr double kLeastExplained = 0.25;

Eigen::Vector3d difference(const Pose2& to, const Pose2& from) {
  return {to.x - from.x, to.y - from.y, wrap_angle(to.yaw - from.yaw)};
}

}  // namespace

void PoseTrack::advance(const PoseWithCovariance2& motion) {
  map_T_robot_ = compound(map_T_robot_, motion);
  map_T_robot_.covariance.diagonal() +=
      Eigen::Vector3d(kDriftM * kDriftM, kDriftM * kDriftM, kDriftRad * kDriftRad);
}

bool PoseTrack::refine(std::span<const Eigen::Vector2d> points_robot, const MapField& field) {
  const MatchResult match = match_to_field(points_robot, field, map_T_robot_.pose, {}, 1);
  if (!has_supported_pose(match.status) || match.score < kLeastExplained) {
    innovation_ += kNewest * (kGate / 3.0 - innovation_);
    return false;
  }
  const Eigen::Matrix3d noise = kCovarianceFactor * match.covariance;
  const Eigen::Vector3d innovation = difference(match.target_T_source, map_T_robot_.pose);
  const Eigen::LDLT<Eigen::Matrix3d> total(map_T_robot_.covariance + noise);
  const double distance2 = innovation.dot(total.solve(innovation));
  innovation_ += kNewest * (std::min(distance2, kGate) / 3.0 - innovation_);
  if (!(distance2 < kGate)) return false;
  const Eigen::Matrix3d gain = total.solve(map_T_robot_.covariance).transpose();
  const Eigen::Vector3d step = gain * innovation;
  Pose2& pose = map_T_robot_.pose;
  pose = {pose.x + step.x(), pose.y + step.y(), wrap_angle(pose.yaw + step.z())};
  // Joseph's form stays symmetric and positive.
  const Eigen::Matrix3d rest = Eigen::Matrix3d::Identity() - gain;
  map_T_robot_.covariance =
      rest * map_T_robot_.covariance * rest.transpose() + gain * noise * gain.transpose();
  return true;
}

}  // namespace loopstone
