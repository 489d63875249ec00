#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "loopstone/grid/grid.hpp"
#include "plan/wall_line.hpp"

namespace loopstone {

/// A gap in one face of a wall, as wide as a door.
struct DoorFace {
  Eigen::Vector2d from{0.0, 0.0};  ///< on the face, map frame [m]; its side is on the left
  Eigen::Vector2d to{0.0, 0.0};
  double sigma_across_m = 0.0;  ///< of the face
  double width_sigma_m = 0.0;

  [[nodiscard]] Eigen::Vector2d middle() const { return 0.5 * (from + to); }
  [[nodiscard]] double width_m() const { return (to - from).norm(); }
  [[nodiscard]] Eigen::Vector2d normal() const {
    const Eigen::Vector2d u = (to - from).normalized();
    return {-u.y(), u.x()};
  }
};

/// Gaps between two ends of one wall, or between a wall's end and another wall that it points to.
/// The end is that of something as thin as a wall. What they lead to is not asked.
[[nodiscard]] std::vector<DoorFace> find_door_faces(const Grid<std::int8_t>& cells,
                                                    const JoinedSegments& joined);

}  // namespace loopstone
