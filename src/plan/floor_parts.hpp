#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/grid/grid.hpp"
#include "plan/door_faces.hpp"

namespace loopstone {

/// The floor, cut at walls and doors.
struct FloorParts {
  static constexpr int kNone = -1;
  Grid<int> part_of{};  ///< of each cell, kNone where there is no floor
  std::vector<double> areas_m2{};

  /// Which part lies on a side of a face, a little way from it.
  [[nodiscard]] int beside(const DoorFace& face, double side) const;
};

/// Floods free cells up to walls and to the faces of doors; floor that things hide joins what is
/// around it, and what is too small to be a room becomes part of none.
[[nodiscard]] FloorParts part_floor(const Grid<std::int8_t>& cells,
                                    std::span<const PlanSegment> segments,
                                    std::span<const DoorFace> faces);

}  // namespace loopstone
