#pragma once

#include <cmath>
#include <numbers>

namespace loopstone {

inline constexpr double kPi = std::numbers::pi;

/// The same angle in (-pi, pi]. The only place where angles are wrapped. NaN stays NaN.
[[nodiscard]] inline double wrap_angle(double angle_rad) {
  if (angle_rad > -kPi && angle_rad <= kPi) return angle_rad;
  const double wrapped = std::remainder(angle_rad, 2.0 * kPi);
  return wrapped <= -kPi ? kPi : wrapped;
}

[[nodiscard]] constexpr double radians(double degrees) { return degrees * (kPi / 180.0); }
[[nodiscard]] constexpr double degrees(double radians) { return radians * (180.0 / kPi); }

}  // namespace loopstone
