#include "loopstone/odometry/odometry_accuracy.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

constexpr double kWindowM = 4.0;
/// Older windows fade.
constexpr double kMostWindows = 40.0;
/// No wheels are better than this for long.
constexpr double kLeastShare = 0.02;
constexpr double kLeastRadPerM = 0.004;

/// The way that errors have added up over.
double grown(double path_m) { return std::min(path_m, std::sqrt(kWindowM * path_m)); }

}  // namespace

void OdometryAccuracy::add(const Pose2& odom_T_robot, const Pose2& local_T_robot, double path_m) {
  if (open_ && path_m - open_->path_m >= kWindowM) {
    const double way_m = path_m - open_->path_m;
    const Pose2 told = open_->odom_T_robot.inverse() * odom_T_robot;
    const Pose2 seen = open_->local_T_robot.inverse() * local_T_robot;
    const double share = std::hypot(told.x - seen.x, told.y - seen.y) / way_m;
    const double turn = wrap_angle(told.yaw - seen.yaw) / way_m;
    windows_ = std::min(windows_ + 1.0, kMostWindows);
    share2_ += (share * share - share2_) / windows_;
    rad_per_m2_ += (turn * turn - rad_per_m2_) / windows_;
    open_.reset();
  }
  if (!open_) open_ = OdometryWindow{odom_T_robot, local_T_robot, path_m};
}

double OdometryAccuracy::sigma_m(double path_m, double reach_m) const {
  const double along_m = std::max(kLeastShare, std::sqrt(share2_)) * grown(path_m);
  return std::hypot(along_m, 0.5 * sigma_rad(path_m) * reach_m);
}

double OdometryAccuracy::sigma_rad(double path_m) const {
  return std::max(kLeastRadPerM, std::sqrt(rad_per_m2_)) * grown(path_m);
}

}  // namespace loopstone
