#include "loopstone/slam/laser_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace loopstone {

namespace {

/// Nearer than this there is nothing but the robot itself and what hangs over it.
constexpr double kBlockedM = 0.35;
/// Share of the returns that must be so near, and how many there must be at least.
constexpr double kBlockedShare = 0.8;
constexpr std::size_t kFewestReturns = 20;
/// Odometry that has moved so far says that the robot does not stand.
constexpr double kMovedM = 0.05;
constexpr double kMovedRad = 0.05;

bool is_blocked(const LaserScan& scan) {
  std::size_t returns = 0;
  std::size_t near = 0;
  for (const float range_m : scan.ranges_m) {
    if (!std::isfinite(range_m)) continue;
    ++returns;
    if (range_m < kBlockedM) ++near;
  }
  return returns >= kFewestReturns &&
         static_cast<double>(near) >= kBlockedShare * static_cast<double>(returns);
}

/// To the last bit: that two scans of a laser that works are so is a matter of its resolution, and
/// of standing still.
bool same_ranges(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && !a.empty() &&
         std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

bool has_moved(const OdometryReading& from, const OdometryReading& to) {
  const Pose2 motion = from.odom_T_robot.inverse() * to.odom_T_robot;
  return std::hypot(motion.x, motion.y) > kMovedM || std::abs(motion.yaw) > kMovedRad;
}

}  // namespace

std::string_view to_string(LaserFault fault) {
  return fault == LaserFault::kBlocked ? "blocked" : "frozen";
}

bool LaserCheck::is_frozen(const LaserScan& scan, const std::optional<OdometryReading>& odometry) {
  if (!same_ranges(scan.ranges_m, last_ranges_m_)) {
    last_ranges_m_ = scan.ranges_m;
    repeated_since_ = odometry;
    repeated_ = 0;
    return false;
  }
  if (odometry && repeated_since_) return has_moved(*repeated_since_, *odometry);
  most_repeated_ = std::max(most_repeated_, ++repeated_);
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
    open_ = false;
    return true;
  }
  if (!open_ || episodes_.back().fault != *fault) {
    episodes_.push_back({.fault = *fault, .from = scan.stamp});
    begun_ = *fault == LaserFault::kFrozen ? repeated_since_ : odometry;
    open_ = true;
  }
  LaserEpisode& episode = episodes_.back();
  episode.to = scan.stamp;
  ++episode.scans;
  if (begun_ && odometry) {
    const Pose2 motion = begun_->odom_T_robot.inverse() * odometry->odom_T_robot;
    episode.odometry_m =
        std::max(odometry->path_m - begun_->path_m, std::hypot(motion.x, motion.y));
    episode.odometry_rad =
        std::max(odometry->turned_rad - begun_->turned_rad, std::abs(motion.yaw));
  }
  return false;
}

}  // namespace loopstone
