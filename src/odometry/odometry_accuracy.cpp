#include "loopstone/odometry/odometry_accuracy.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/base/sound_state.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

/// The way that errors have added up over.
double grown(double path_m) {
  return std::min(path_m, std::sqrt(kOdometryAccuracy.window_m * path_m));
}

}  // namespace

void OdometryAccuracy::add(const Pose2& odom_T_robot, const Pose2& local_T_robot, double path_m) {
  if (state_.open && path_m - state_.open->path_m >= kOdometryAccuracy.window_m) {
    const double way_m = path_m - state_.open->path_m;
    const Pose2 told = state_.open->odom_T_robot.inverse() * odom_T_robot;
    const Pose2 seen = state_.open->local_T_robot.inverse() * local_T_robot;
    const double share = std::hypot(told.x - seen.x, told.y - seen.y) / way_m;
    const double turn = wrap_angle(told.yaw - seen.yaw) / way_m;
    state_.windows = std::min(state_.windows + 1.0, kOdometryAccuracy.most_windows);
    state_.share2 += (share * share - state_.share2) / state_.windows;
    state_.rad_per_m2 += (turn * turn - state_.rad_per_m2) / state_.windows;
    state_.open.reset();
  }
  if (!state_.open) state_.open = OdometryWindow{odom_T_robot, local_T_robot, path_m};
}

double OdometryAccuracy::sigma_m(double path_m, double reach_m) const {
  const double along_m =
      std::max(kOdometryAccuracy.least_share, std::sqrt(state_.share2)) * grown(path_m);
  return std::hypot(along_m, 0.5 * sigma_rad(path_m) * reach_m);
}

double OdometryAccuracy::sigma_rad(double path_m) const {
  return std::max(kOdometryAccuracy.least_rad_per_m, std::sqrt(state_.rad_per_m2)) * grown(path_m);
}

void OdometryAccuracy::restore(const State& state) {
  require_sound(is_amount(state.share2) && is_amount(state.rad_per_m2) && state.windows >= 1.0 &&
                    state.windows <= kOdometryAccuracy.most_windows,
                "an accuracy of odometry that can't be");
  state_ = state;
}

}  // namespace loopstone
