#include "slam/path_drift.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/covariance.hpp"

namespace loopstone {

namespace {

constexpr double kUnit = kPathDrift.prior * kPathDrift.prior;

/// Uncertainty of a match beyond its own noise, in those of a motion that odometry tells.
Eigen::Matrix3d beyond_noise(const Eigen::Matrix3d& covariance) {
  const Eigen::Vector3d floor(kPathDrift.floor_m, kPathDrift.floor_m, kPathDrift.floor_rad);
  Eigen::Matrix3d excess = covariance;
  excess.diagonal() -= floor.cwiseAbs2();
  return excess / kUnit;
}

/// What of it the matches after it do not take back.
/// \param off  of the motion from what odometry says of it, local frame; nothing where that does
///             not count
Eigen::Matrix3d lasting(const Eigen::Matrix3d& covariance, double distance,
                        const std::optional<Eigen::Vector3d>& off) {
  const SymmetricEigen<double, 3> axes = symmetric_eigen(beyond_noise(covariance));
  Eigen::Vector3d kept;
  for (int i = 0; i < 3; ++i) {
    const double open = std::max(axes.values(i), 0.0);
    const double lag = 1.0 + kPathDrift.memory * (1.0 - std::min(open, 1.0));
    kept(i) = kUnit * open / (lag * lag);
    const Eigen::Vector3d axis = axes.vectors.col(i);
    if (!off || open < kPathDrift.open_share) continue;
    kept(i) = std::min(
        kept(i), std::pow(axis.dot(*off), 2) + kPathDrift.walk_m * kPathDrift.walk_m * distance);
  }
  return axes.vectors * kept.asDiagonal() * axes.vectors.transpose();
}

double length(const Pose2& motion) { return hypotenuse(motion.x, motion.y); }

}  // namespace

StepDrift drift_between(const KeyScan& previous, const KeyScan& next,
                        const std::optional<Pose2>& told) {
  const Pose2 motion = previous.local_T_robot.inverse() * next.local_T_robot;
  const double distance = next.across ? 0.0 : length(motion);
  std::optional<Eigen::Vector3d> off;
  if (told) {
    off.emplace();
    *off << previous.local_T_robot.rotation() * (motion.translation() - told->translation()),
        wrap_angle(motion.yaw - told->yaw);
  }
  const double sigma = kPathDrift.rest_m + kPathDrift.travel_share * distance;
  const double sigma_yaw = kPathDrift.rest_rad + kPathDrift.turn_share * std::abs(motion.yaw);
  Eigen::Matrix3d covariance = lasting(next.covariance, distance, off);
  if (next.across) covariance += *next.across;
  covariance = rotated(covariance, next.local_T_robot.rotation().transpose());
  covariance.diagonal() += Eigen::Vector3d(sigma * sigma, sigma * sigma, sigma_yaw * sigma_yaw);
  StepDrift drift{.covariance = covariance,
                  .open = rests_on_odometry(next.covariance),
                  .broken = next.across.has_value()};
  if (off && !next.across) drift.off = next.local_T_robot.rotation().transpose() * off->head<2>();
  return drift;
}

bool rests_on_odometry(const Eigen::Matrix3d& covariance) {
  const SymmetricEigen<double, 2> axes =
      symmetric_eigen<double, 2>(beyond_noise(covariance).topLeftCorner<2, 2>());
  return axes.values(1) >= kPathDrift.open_share;
}

std::optional<Pose2> told_between(const KeyScan& previous, const KeyScan& next,
                                  const ToldPath& path) {
  const auto& track = path.track;
  if (!(path.scale > 0.0) || std::max(previous.scan, next.scan) >= track.size()) return {};
  const auto gap = std::ranges::upper_bound(path.breaks, previous.stamp, {}, &PathBreak::to);
  if (gap != path.breaks.end() && gap->from < next.stamp) return {};
  const auto& from = track[previous.scan].odom_T_robot;
  const auto& to = track[next.scan].odom_T_robot;
  if (!from || !to) return {};
  Pose2 told = from->inverse() * *to;
  told.x /= path.scale;
  told.y /= path.scale;
  return told;
}

double open_travel_error_m(std::span<const KeyScan> keys, const ToldPath& path) {
  double sum_m = 0.0;
  for (std::size_t k = 1; k < keys.size(); ++k) {
    const KeyScan& previous = keys[k - 1];
    const KeyScan& next = keys[k];
    if (next.across || !rests_on_odometry(next.covariance)) continue;
    if (const auto told = told_between(previous, next, path))
      sum_m += length(previous.local_T_robot.inverse() * next.local_T_robot) - length(*told);
  }
  return sum_m;
}

}  // namespace loopstone
