#pragma once

#include <cmath>
#include <cstdint>

#include "loopstone/grid/grid.hpp"
#include "support/segment_world.hpp"

// Maps of places made of walls.
namespace loopstone::test {

/// Every cell that a wall passes, to half a cell; the rest is free.
[[nodiscard]] inline Grid<std::int8_t> drawn(const Walls& walls, const Eigen::Vector2d& low,
                                             const Eigen::Vector2d& high,
                                             double resolution_m = 0.05) {
  Grid<std::int8_t> map(frame_covering(low, high, resolution_m, 1.5), 0);
  for (int row = 0; row < map.frame().rows; ++row) {
    for (int column = 0; column < map.frame().columns; ++column) {
      const Cell cell{column, row};
      if (distance_to_walls(walls, map.frame().centre_of(cell)) < 0.55 * resolution_m)
        map[cell] = 100;
    }
  }
  return map;
}

/// A rectangle that is free inside and solid outside. Its sides lie on the borders of cells, so
/// that the cells that show them have their centres half a cell behind what a laser measures.
[[nodiscard]] inline Grid<std::int8_t> drawn_solid(const Eigen::Vector2d& low,
                                                   const Eigen::Vector2d& high,
                                                   double resolution_m = 0.05) {
  Grid<std::int8_t> map(frame_covering(low, high, resolution_m, 0.2), 100);
  for (int row = 0; row < map.frame().rows; ++row) {
    for (int column = 0; column < map.frame().columns; ++column) {
      const Cell cell{column, row};
      const Eigen::Vector2d centre = map.frame().centre_of(cell);
      if ((centre.array() > low.array()).all() && (centre.array() < high.array()).all())
        map[cell] = 0;
    }
  }
  return map;
}

}  // namespace loopstone::test
