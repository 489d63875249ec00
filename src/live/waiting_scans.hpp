#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <variant>

#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/mounted_scan.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// Scans that are shown when it is known where they were taken. Of too many the oldest go.
class WaitingScans {
 public:
  /// Takes scans, as they were mounted, and leaves all else.
  void add(const SensorMessage& message, const RobotModel& robot) {
    const auto* const scan = std::get_if<LaserScan>(&message);
    if (scan == nullptr) return;
    if (scans_.size() >= kMost) scans_.pop_front();
    const auto mounted = as_mounted(*scan, robot);
    scans_.push_back(mounted ? *mounted : *scan);
  }
  /// Null when there is none.
  [[nodiscard]] const LaserScan* at(Stamp stamp) const {
    const auto scan = std::ranges::find(scans_, stamp, &LaserScan::stamp);
    return scan == scans_.end() ? nullptr : &*scan;
  }
  /// Those of other lasers may have the same stamp.
  void drop_before(Stamp stamp) {
    while (!scans_.empty() && scans_.front().stamp < stamp) scans_.pop_front();
  }
  void clear() { scans_.clear(); }

 private:
  static constexpr std::size_t kMost = 100;
  std::deque<LaserScan> scans_{};
};

}  // namespace loopstone
