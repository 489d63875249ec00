#pragma once

#include <optional>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// Dead reckoning at a scan's stamp.
struct OdometryReading {
  Pose2 odom_T_robot;
  bool has_translation = true;  ///< false: a gyro alone, only the heading counts
  double path_m = 0.0;          ///< travelled since the recording began
  double turned_rad = 0.0;      ///< turned since then, either way
  /// Of that, what the gyro felt while all wheels stood.
  double turned_by_hand_rad = 0.0;
  /// When it was last silent for a while, and spoke again: motion across a silence is hearsay.
  std::optional<Stamp> silent_until{};

  template <typename Archive>
  void archive(Archive& a) {
    a(odom_T_robot, has_translation, path_m, turned_rad, turned_by_hand_rad, silent_until);
  }
};

}  // namespace loopstone
