#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "devices/rplidar_nodes.hpp"
#include "loopstone/sensor/laser_scan.hpp"

namespace loopstone {

/// All measurements of one turn.
struct RplidarTurn {
  std::vector<RplidarNode> nodes{};
  std::int64_t first_sample = 0;
  std::int64_t end_sample = 0;  ///< first of the next turn
  bool after_gap = false;       ///< something was lost since the last whole turn

  [[nodiscard]] std::int64_t samples() const { return end_sample - first_sample; }
};

/// Gathers measurements to whole turns; what something was lost of is left out.
class RplidarTurns {
 public:
  [[nodiscard]] std::optional<RplidarTurn> add(const RplidarNode& node);
  /// Turns that were left out.
  [[nodiscard]] std::int64_t broken() const { return broken_; }

 private:
  RplidarTurn turn_{};
  bool is_whole_ = false;  ///< so far; the first one begins in its middle
  bool has_begun_ = false;
  std::int64_t broken_ = 0;
};

/// The even grid of angles that turns are brought to.
struct RplidarGrid {
  int beams = 0;
  double range_min_m = 0.0;
  double range_max_m = 0.0;

  /// Negative: the device turns clockwise.
  [[nodiscard]] double angle_increment_rad() const;
  /// Ranges and, when asked for, intensities of a scan. Of the measurements of a beam the nearest
  /// counts; a beam without any is bad, for nothing is known of it.
  [[nodiscard]] LaserScan scan_of(const RplidarTurn& turn, bool intensities) const;
};

/// Beams for turns of about so many measurements: a few less, so that hardly a beam is left without
/// one when the motor turns a little faster.
[[nodiscard]] int rplidar_beams(std::int64_t samples);

}  // namespace loopstone
