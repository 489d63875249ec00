#pragma once

#include <Eigen/Core>
#include <cmath>

#include "loopstone/grid/grid_frame.hpp"

// Frames of one resolution whose cells coincide: all are cut from one grid without edges, whose
// cell (0, 0) has its lower left corner at the origin of the map.

namespace loopstone {

/// Of a frame's lower left cell on the grid that all of this width share.
[[nodiscard]] inline Cell corner_of(const GridFrame& frame) {
  return {static_cast<int>(std::lround(frame.origin.x() / frame.resolution)),
          static_cast<int>(std::lround(frame.origin.y() / frame.resolution))};
}

[[nodiscard]] inline bool lies_on_grid(const GridFrame& frame) {
  const Cell corner = corner_of(frame);
  const Eigen::Vector2d off =
      frame.origin / frame.resolution - Eigen::Vector2d(corner.column, corner.row);
  return off.cwiseAbs().maxCoeff() < 1e-3;
}

}  // namespace loopstone
