#pragma once

#include <Eigen/Core>
#include <cmath>

namespace loopstone {

/// Directions in the plane cut into kDirectionBins bins, counter-clockwise, by the angle on a
/// diamond instead of a circle: it grows with the true angle and costs one division.
inline constexpr int kDirectionBins = 1024;

[[nodiscard]] inline int direction_bin(double x, double y) {
  const double length = std::abs(x) + std::abs(y);
  if (!(length > 0.0)) return 0;
  const double p = y / length;
  const double around = x >= 0.0 ? p + 1.0 : 3.0 - p;  // [0, 4)
  const int bin = static_cast<int>(around * (0.25 * kDirectionBins));
  return bin & (kDirectionBins - 1);
}

}  // namespace loopstone
