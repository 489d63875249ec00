#pragma once

#include <optional>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// One sweep of a planar laser scanner. Beam i points to angle_min_rad + i * angle_increment_rad,
/// counter-clockwise from the lidar's x axis.
///
/// Ranges follow REP-117: a finite value in [range_min_m, range_max_m] is a return; +inf means
/// nothing within range (the beam is free up to range_max_m); NaN means the beam is bad and says
/// nothing. Readers translate whatever a format uses (0, 81.83, max + 1) to these two and nothing
/// else.
struct LaserScan {
  Stamp stamp;  ///< of the first beam
  double angle_min_rad = 0.0;
  double angle_increment_rad = 0.0;  ///< may be negative (clockwise scanners)
  double range_min_m = 0.0;
  double range_max_m = 0.0;
  double time_increment_s = 0.0;  ///< between neighbouring beams; 0 when unknown or simultaneous
  int lidar = 0;                  ///< index into RobotModel::lidars
  std::optional<Pose2>
      robot_T_lidar{};  ///< when the log itself states where the lidar sat; beats the RobotModel
  std::vector<float> ranges_m{};
  /// How bright each beam's echo was, in the scanner's own unit; empty when nobody asked for it or
  /// the log has none. No part of what a session keeps.
  std::vector<float> intensities{};

  [[nodiscard]] double angle_rad(std::size_t beam) const {
    return angle_min_rad + static_cast<double>(beam) * angle_increment_rad;
  }

  template <typename Archive>
  void archive(Archive& a) {
    a(stamp, angle_min_rad, angle_increment_rad, range_min_m, range_max_m, time_increment_s, lidar,
      robot_T_lidar, ranges_m);
  }
};

}  // namespace loopstone
