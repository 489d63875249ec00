#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "loopstone/grid/grid.hpp"
#include "plan/plan_numbers.hpp"

namespace loopstone {

/// Free: observed, and nothing there. What lies beyond the map is not.
[[nodiscard]] inline bool is_free_cell(const Grid<std::int8_t>& cells, Cell cell) {
  const std::int8_t value = cells.value_or(cell, -1);
  return value >= 0 && value < kPlan.occupied_percent;
}

[[nodiscard]] inline bool is_occupied_cell(const Grid<std::int8_t>& cells, Cell cell) {
  return cells.value_or(cell, -1) >= kPlan.occupied_percent;
}

/// Of points spread over a line, the share that lies on free cells.
[[nodiscard]] inline double free_share(const Grid<std::int8_t>& cells, const Eigen::Vector2d& from,
                                       const Eigen::Vector2d& to) {
  const double step_m = 0.4 * cells.frame().resolution;
  const int count = std::max(1, static_cast<int>(std::ceil((to - from).norm() / step_m)));
  int free = 0;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d at = from + (i + 0.5) / count * (to - from);
    free += static_cast<int>(is_free_cell(cells, cells.frame().cell_of(at)));
  }
  return static_cast<double>(free) / count;
}

}  // namespace loopstone
