#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <span>

#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

// What a ray hits, the same for every caster of this part. A grid stands in an endless plane;
// outside it everything is open, so a ray may come in from outside and leave again. The range of a
// ray is the distance at which it enters the first occupied cell: 0 when it starts in one, +inf
// when there is none within the greatest range. A cell holds its lower and left edge, so a ray
// along an edge meets the cells right of or above it (as in ray_walk.hpp).

/// A half line. A direction that is not of unit length, or a number that is not finite, gives a
/// range without meaning.
struct Ray {
  Eigen::Vector2d origin;     ///< map frame [m]
  Eigen::Vector2d direction;  ///< unit length
};

[[nodiscard]] inline Ray ray_along(const Pose2& map_T_beam) {
  return {map_T_beam.translation(), {std::cos(map_T_beam.yaw), std::sin(map_T_beam.yaw)}};
}

/// Beams of scans: beam k of pose i points to map_T_lidar[i].yaw + angles_rad[k]. Its range goes to
/// ranges[i * angles_rad.size() + k].
struct ScanRays {
  std::span<const Pose2> map_T_lidar;
  std::span<const double> angles_rad;

  [[nodiscard]] std::size_t size() const { return map_T_lidar.size() * angles_rad.size(); }
};

}  // namespace loopstone
