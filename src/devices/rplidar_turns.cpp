#include "devices/rplidar_turns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {

std::optional<RplidarTurn> RplidarTurns::add(const RplidarNode& node) {
  /// No turn has more: a motor that stands still, or flags that never come.
  constexpr std::size_t kMostNodes = 100'000;
  if (node.after_gap || turn_.nodes.size() >= kMostNodes) {
    if (has_begun_ && is_whole_) ++broken_;
    is_whole_ = false;
    turn_.nodes.clear();
    turn_.after_gap = true;
  }
  std::optional<RplidarTurn> done;
  if (node.begins_turn) {
    if (is_whole_) {
      turn_.end_sample = node.sample;
      done = std::exchange(turn_, {});
    }
    turn_.nodes.clear();
    turn_.first_sample = node.sample;
    is_whole_ = true;
    has_begun_ = true;
  }
  turn_.nodes.push_back(node);
  return done;
}

double RplidarGrid::angle_increment_rad() const { return -2.0 * kPi / beams; }

LaserScan RplidarGrid::scan_of(const RplidarTurn& turn, bool intensities) const {
  constexpr float kNothing = std::numeric_limits<float>::infinity();
  constexpr float kBad = std::numeric_limits<float>::quiet_NaN();
  LaserScan scan{.stamp = {},
                 .angle_min_rad = 0.0,
                 .angle_increment_rad = angle_increment_rad(),
                 .range_min_m = range_min_m,
                 .range_max_m = range_max_m};
  const auto count = static_cast<std::size_t>(beams);
  scan.ranges_m.assign(count, kBad);
  if (intensities) scan.intensities.assign(count, 0.0F);
  for (const RplidarNode& node : turn.nodes) {
    const auto beam =
        static_cast<std::size_t>(std::lround(node.angle_rad / -scan.angle_increment_rad) % beams);
    const bool is_return = node.range_m > 0.0 && node.range_m <= range_max_m;
    if (is_return && node.range_m < range_min_m) continue;  // nearer than it can measure
    const float range_m = is_return ? static_cast<float>(node.range_m) : kNothing;
    float& best_m = scan.ranges_m[beam];
    if (!std::isnan(best_m) && best_m <= range_m) continue;
    best_m = range_m;
    if (intensities) scan.intensities[beam] = is_return ? static_cast<float>(node.quality) : 0.0F;
  }
  return scan;
}

int rplidar_beams(std::int64_t samples) {
  constexpr double kShare = 0.95;
  constexpr double kFewest = 8.0;
  return static_cast<int>(std::max(kFewest, std::floor(kShare * static_cast<double>(samples))));
}

}  // namespace loopstone
