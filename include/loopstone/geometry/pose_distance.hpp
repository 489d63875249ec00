#pragma once

#include <cmath>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// Do two poses differ by less than so much in position and by less than so much in heading?
[[nodiscard]] inline bool is_within(const Pose2& a, const Pose2& b, double metres, double radians) {
  return hypotenuse(a.x - b.x, a.y - b.y) < metres && std::abs(wrap_angle(a.yaw - b.yaw)) < radians;
}

}  // namespace loopstone
