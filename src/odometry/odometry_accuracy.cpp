#include "loopstone/odometry/odometry_accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/base/sound_state.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

constexpr auto kMostWindows = static_cast<std::size_t>(kOdometryAccuracy.most_windows);

/// The way that errors have added up over.
double grown(double path_m) {
  return std::min(path_m, std::sqrt(kOdometryAccuracy.window_m * path_m));
}

}  // namespace

void OdometryAccuracy::add(const Pose2& odom_T_robot, const Pose2& local_T_robot, double path_m) {
  if (state_.open && path_m - state_.open->path_m >= kOdometryAccuracy.window_m) {
    state_.windows.push_back({state_.open->odom_T_robot.inverse() * odom_T_robot,
                              state_.open->local_T_robot.inverse() * local_T_robot,
                              path_m - state_.open->path_m});
    if (state_.windows.size() > kMostWindows) state_.windows.pop_front();
    state_.open.reset();
  }
  if (!state_.open) state_.open = OdometryWindow{odom_T_robot, local_T_robot, path_m};
}

OdometryAccuracy::Sigma OdometryAccuracy::sigma(double path_m, double reach_m,
                                                const OdometryCorrection& correction) const {
  // The first guess counts as one window, until there are enough.
  const double first = state_.windows.size() < kMostWindows ? 1.0 : 0.0;
  double share2 = first * kOdometryAccuracy.first_share * kOdometryAccuracy.first_share;
  double rad_per_m2 = first * kOdometryAccuracy.first_rad_per_m * kOdometryAccuracy.first_rad_per_m;
  for (const OdometryWindowMotion& window : state_.windows) {
    const Pose2 told = correction.corrected(window.told, window.way_m);
    const double share = (told.translation() - window.seen.translation()).norm() / window.way_m;
    const double turn = wrap_angle(told.yaw - window.seen.yaw) / window.way_m;
    share2 += share * share;
    rad_per_m2 += turn * turn;
  }
  const double count = first + static_cast<double>(state_.windows.size());
  const double grown_m = grown(path_m);
  const double along_m =
      std::max(kOdometryAccuracy.least_share, std::sqrt(share2 / count)) * grown_m;
  const double rad =
      std::max(kOdometryAccuracy.least_rad_per_m, std::sqrt(rad_per_m2 / count)) * grown_m;
  return {hypotenuse(along_m, 0.5 * rad * reach_m), rad};
}

std::optional<double> OdometryAccuracy::usual_rad(const OdometryCorrection& correction) const {
  if (state_.windows.size() < static_cast<std::size_t>(kOdometryAccuracy.fewest_windows)) return {};
  std::vector<double> turns_rad;
  for (const OdometryWindowMotion& window : state_.windows) {
    const Pose2 told = correction.corrected(window.told, window.way_m);
    turns_rad.push_back(std::abs(wrap_angle(told.yaw - window.seen.yaw)));
  }
  const auto middle = turns_rad.begin() + static_cast<std::ptrdiff_t>(turns_rad.size() / 2);
  std::ranges::nth_element(turns_rad, middle);
  return *middle;
}

void OdometryAccuracy::restore(State state) {
  require_sound(state.windows.size() <= kMostWindows, "more windows than are remembered");
  for (const OdometryWindowMotion& window : state.windows)
    require_sound(window.told.vector().allFinite() && window.seen.vector().allFinite() &&
                      std::isfinite(window.way_m) && window.way_m >= kOdometryAccuracy.window_m,
                  "an accuracy of odometry that can't be");
  state_ = std::move(state);
}

}  // namespace loopstone
