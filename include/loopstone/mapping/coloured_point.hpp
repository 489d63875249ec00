#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace loopstone {

/// A point of the map in its colour.
struct ColouredPoint {
  Eigen::Vector3f position_m = Eigen::Vector3f::Zero();  ///< map frame
  std::array<std::uint8_t, 3> rgb{};                     ///< sRGB
};

}  // namespace loopstone
