#include "loopstone/slam/laser_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "loopstone/base/sound_state.hpp"

namespace loopstone {

namespace {

bool is_blocked(const LaserScan& scan) {
  std::size_t returns = 0;
  std::size_t near = 0;
  for (const float range_m : scan.ranges_m) {
    if (!std::isfinite(range_m)) continue;
    ++returns;
    if (range_m < kLaserCheck.blocked_m) ++near;
  }
  return returns >= static_cast<std::size_t>(kLaserCheck.fewest_returns) &&
         static_cast<double>(near) >= kLaserCheck.blocked_share * static_cast<double>(returns);
}

/// To the last bit: that two scans of a laser that works are so is a matter of its resolution, and
/// of standing still.
bool same_ranges(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && !a.empty() &&
         std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

bool has_moved(const OdometryReading& from, const OdometryReading& to) {
  const Pose2 motion = from.odom_T_robot.inverse() * to.odom_T_robot;
  return std::hypot(motion.x, motion.y) > kLaserCheck.moved_m ||
         std::abs(motion.yaw) > kLaserCheck.moved_rad;
}

}  // namespace

bool LaserCheck::is_frozen(const LaserScan& scan, const std::optional<OdometryReading>& odometry) {
  if (!same_ranges(scan.ranges_m, state_.last_ranges_m)) {
    state_.last_ranges_m = scan.ranges_m;
    state_.repeated_since = odometry;
    state_.repeated = 0;
    return false;
  }
  if (odometry && state_.repeated_since) return has_moved(*state_.repeated_since, *odometry);
  state_.most_repeated = std::max(state_.most_repeated, ++state_.repeated);
  return false;
}

std::optional<LaserFault> LaserCheck::fault_of(const LaserScan& scan,
                                               const std::optional<OdometryReading>& odometry) {
  // A scan without returns repeats itself for good reason.
  const bool any = std::any_of(scan.ranges_m.begin(), scan.ranges_m.end(),
                               [](float range_m) { return std::isfinite(range_m); });
  if (!any) return {};
  if (is_frozen(scan, odometry)) return LaserFault::kFrozen;
  if (is_blocked(scan)) return LaserFault::kBlocked;
  return {};
}

bool LaserCheck::add(const LaserScan& scan, const std::optional<OdometryReading>& odometry) {
  const auto fault = fault_of(scan, odometry);
  if (!fault) {
    state_.open = false;
    return true;
  }
  if (!state_.open || state_.episodes.back().fault != *fault) {
    state_.episodes.push_back({.fault = *fault, .from = scan.stamp});
    state_.begun = *fault == LaserFault::kFrozen ? state_.repeated_since : odometry;
    state_.open = true;
  }
  LaserEpisode& episode = state_.episodes.back();
  episode.to = scan.stamp;
  ++episode.scans;
  if (state_.begun && odometry) {
    const Pose2 motion = state_.begun->odom_T_robot.inverse() * odometry->odom_T_robot;
    episode.odometry_m =
        std::max(odometry->path_m - state_.begun->path_m, std::hypot(motion.x, motion.y));
    episode.odometry_rad =
        std::max(odometry->turned_rad - state_.begun->turned_rad, std::abs(motion.yaw));
  }
  return false;
}

void LaserCheck::restore(State state) {
  require_sound(!state.open || !state.episodes.empty(), "a fault of the laser that never began");
  require_sound(state.repeated <= state.most_repeated, "scans repeated more often than ever");
  state_ = std::move(state);
}

}  // namespace loopstone
