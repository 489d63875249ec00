#pragma once

#include <cmath>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// Whether a pose lies so near to where it was told that it is not told anew.
[[nodiscard]] inline bool is_still(const Pose2& told, const Pose2& now) {
  constexpr double kStillM = 1e-3;
  constexpr double kStillRad = 1e-3;
  return std::abs(told.x - now.x) < kStillM && std::abs(told.y - now.y) < kStillM &&
         std::abs(wrap_angle(told.yaw - now.yaw)) < kStillRad;
}

}  // namespace loopstone
