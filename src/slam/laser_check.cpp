#include "loopstone/slam/laser_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "loopstone/base/hypotenuse.hpp"
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
  return hypotenuse(motion.x, motion.y) > kLaserCheck.moved_m ||
         std::abs(motion.yaw) > kLaserCheck.moved_rad;
}

}  // namespace

LaserCheck::Laser& LaserCheck::laser_of(const LaserScan& scan) {
  const auto known = std::ranges::find(state_.lasers, scan.lidar, &Laser::lidar);
  if (known != state_.lasers.end()) return *known;
  state_.lasers.push_back({.lidar = scan.lidar});
  return state_.lasers.back();
}

bool LaserCheck::is_open(std::size_t episode) const {
  return std::ranges::any_of(state_.lasers,
                             [&](const Laser& laser) { return laser.open == episode; });
}

bool LaserCheck::is_faulty() const {
  return std::ranges::any_of(state_.lasers,
                             [](const Laser& laser) { return laser.open.has_value(); });
}

bool LaserCheck::is_frozen(const LaserScan& scan, Laser& laser,
                           const std::optional<OdometryReading>& odometry) {
  if (!same_ranges(scan.ranges_m, laser.last_ranges_m)) {
    laser.last_ranges_m = scan.ranges_m;
    laser.repeated_since = odometry;
    laser.repeated = 0;
    return false;
  }
  if (odometry && laser.repeated_since) return has_moved(*laser.repeated_since, *odometry);
  state_.most_repeated = std::max(state_.most_repeated, ++laser.repeated);
  return false;
}

std::optional<LaserFault> LaserCheck::fault_of(const LaserScan& scan, Laser& laser,
                                               const std::optional<OdometryReading>& odometry,
                                               bool is_covered) {
  // A scan without returns repeats itself for good reason.
  const bool any = std::any_of(scan.ranges_m.begin(), scan.ranges_m.end(),
                               [](float range_m) { return std::isfinite(range_m); });
  if (!any) return {};
  if (is_frozen(scan, laser, odometry)) return LaserFault::kFrozen;
  if (is_blocked(scan)) return LaserFault::kBlocked;
  if (is_covered) return LaserFault::kCovered;
  return {};
}

bool LaserCheck::add(const LaserScan& scan, const std::optional<OdometryReading>& odometry,
                     bool is_covered) {
  Laser& laser = laser_of(scan);
  const auto fault = fault_of(scan, laser, odometry, is_covered);
  if (!fault) {
    laser.open.reset();
    return true;
  }
  if (!laser.open || state_.episodes[*laser.open].fault != *fault) {
    laser.open = state_.episodes.size();
    state_.episodes.push_back({.fault = *fault, .lidar = scan.lidar, .from = scan.stamp});
    laser.begun = *fault == LaserFault::kFrozen ? laser.repeated_since : odometry;
  }
  LaserEpisode& episode = state_.episodes[*laser.open];
  episode.to = scan.stamp;
  ++episode.scans;
  if (laser.begun && odometry) {
    const Pose2 motion = laser.begun->odom_T_robot.inverse() * odometry->odom_T_robot;
    episode.odometry_m =
        std::max(odometry->path_m - laser.begun->path_m, hypotenuse(motion.x, motion.y));
    episode.odometry_rad =
        std::max(odometry->turned_rad - laser.begun->turned_rad, std::abs(motion.yaw));
  }
  return fault == LaserFault::kCovered;
}

void LaserCheck::restore(State state) {
  for (const Laser& laser : state.lasers) {
    require_sound(!laser.open || *laser.open < state.episodes.size(),
                  "a fault of the laser that never began");
    require_sound(laser.repeated <= state.most_repeated, "scans repeated more often than ever");
  }
  state_ = std::move(state);
}

}  // namespace loopstone
