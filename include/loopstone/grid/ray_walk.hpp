#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "loopstone/grid/grid_frame.hpp"

namespace loopstone {

// Which cells does a beam cross? Answered in whole numbers: a point is rounded down to 1/1024 of a
// cell (0.05 mm in a 5 cm grid), and from there on nothing is rounded. The cells of a segment are
// {floor(p) : p on the segment, both ends included}: an edge belongs to the cell right of or above
// it. The set is the same from either end, and a clipped walk visits exactly the cells of the whole
// walk that lie inside.

/// A point in units of 1/1024 cell from the grid's lower left corner. |x|, |y| below 2^30, about a
/// million cells.
struct GridPoint {
  std::int32_t x = 0;
  std::int32_t y = 0;
  friend bool operator==(const GridPoint&, const GridPoint&) = default;
};

inline constexpr int kGridPointBits = 10;
inline constexpr std::int64_t kGridPointsPerCell = std::int64_t{1} << kGridPointBits;

/// The point's cell is frame.cell_of(point), always.
[[nodiscard]] inline GridPoint grid_point_of(const GridFrame& frame, const Eigen::Vector2d& point) {
  constexpr auto kScale = static_cast<double>(kGridPointsPerCell);
  return {floor_to_int((point.x() - frame.origin.x()) / frame.resolution * kScale),
          floor_to_int((point.y() - frame.origin.y()) / frame.resolution * kScale)};
}

[[nodiscard]] inline Cell cell_of(GridPoint point) {
  return {point.x >> kGridPointBits, point.y >> kGridPointBits};
}

/// Calls visit(Cell) for every cell of the segment, in order from `from` to `to`.
/// Cost: one addition and one comparison a cell.
/// Source: Amanatides and Woo 1987, "A fast voxel traversal algorithm for ray tracing", in
/// integers.
template <typename Visit>
void walk_ray(GridPoint from, GridPoint to, Visit&& visit) {
  const std::int64_t dx = std::int64_t{to.x} - from.x;
  const std::int64_t dy = std::int64_t{to.y} - from.y;
  const std::int64_t length_x = std::abs(dx);
  const std::int64_t length_y = std::abs(dy);
  Cell cell = cell_of(from);
  const Cell last = cell_of(to);
  // Distance along each axis to the first edge. Towards +, an edge is entered when it is reached;
  // towards -, only after it.
  const std::int64_t in_cell_x = from.x & (kGridPointsPerCell - 1);
  const std::int64_t in_cell_y = from.y & (kGridPointsPerCell - 1);
  const std::int64_t to_edge_x = dx >= 0 ? kGridPointsPerCell - in_cell_x : in_cell_x;
  const std::int64_t to_edge_y = dy >= 0 ? kGridPointsPerCell - in_cell_y : in_cell_y;
  // ahead = (time of the next x edge - time of the next y edge) * length_x * length_y.
  std::int64_t ahead = to_edge_x * length_y - to_edge_y * length_x;
  const int step_x = dx >= 0 ? 1 : -1;
  const int step_y = dy >= 0 ? 1 : -1;
  visit(cell);
  while (cell != last) {
    // Through a corner: both at once when both are entered alike, else the axis that runs towards +
    // comes first.
    const bool x_first = ahead < 0 || (ahead == 0 && (step_x == step_y || step_x > 0));
    const bool y_first = ahead > 0 || (ahead == 0 && (step_x == step_y || step_y > 0));
    if (x_first) {
      cell.column += step_x;
      ahead += kGridPointsPerCell * length_y;
    }
    if (y_first) {
      cell.row += step_y;
      ahead -= kGridPointsPerCell * length_x;
    }
    visit(cell);
  }
}

/// Calls visit(row, first_column, last_column) for each row of the segment with first_row <= row <
/// end_row, from the lowest row up. Together these are exactly the cells of walk_ray in those rows.
/// Starting in the middle costs one division, so several threads can share a grid by rows.
template <typename Visit>
void walk_ray_rows(GridPoint from, GridPoint to, int first_row, int end_row, Visit&& visit) {
  if (from.y > to.y) std::swap(from, to);
  const int row_begin = std::max(from.y >> kGridPointBits, first_row);
  const int row_last = std::min(to.y >> kGridPointBits, end_row - 1);
  if (row_begin > row_last) return;
  const int from_column = from.x >> kGridPointBits;
  const int to_column = to.x >> kGridPointBits;
  const std::int64_t dx = std::int64_t{to.x} - from.x;
  const std::int64_t dy = std::int64_t{to.y} - from.y;
  if ((from.y >> kGridPointBits) == (to.y >> kGridPointBits)) {
    visit(row_begin, std::min(from_column, to_column), std::max(from_column, to_column));
    return;
  }
  // At the lower edge of row j the segment is in column floor(n / d) with n = from.x dy + (1024 j -
  // from.y) dx and d = 1024 dy; from row to row n grows by 1024 dx, so quotient and remainder
  // follow by addition.
  const std::int64_t d = kGridPointsPerCell * dy;
  const auto floor_divide = [d](std::int64_t n) {
    const std::int64_t quotient = n / d;
    return n % d < 0 ? quotient - 1 : quotient;
  };
  const bool starts_below = (from.y >> kGridPointBits) < row_begin;
  const std::int64_t first_edge = std::int64_t{row_begin} + (starts_below ? 0 : 1);
  const std::int64_t n = from.x * dy + (kGridPointsPerCell * first_edge - from.y) * dx;
  std::int64_t column = floor_divide(n);
  std::int64_t remainder = n - column * d;
  const std::int64_t column_step = floor_divide(kGridPointsPerCell * dx);
  const std::int64_t remainder_step = kGridPointsPerCell * dx - column_step * d;
  const auto to_next_edge = [&] {
    remainder += remainder_step;
    // No branch: a processor could only guess which way it goes.
    const std::int64_t carry = remainder >= d ? 1 : 0;
    column += column_step + carry;
    remainder -= d & -carry;
  };
  auto at_lower_edge = static_cast<int>(column);
  if (starts_below) {
    to_next_edge();
  } else {
    at_lower_edge = from_column;
  }
  for (int row = row_begin; row <= row_last; ++row) {
    const bool ends_here = row == (to.y >> kGridPointBits);
    const int at_upper_edge = ends_here ? to_column : static_cast<int>(column);
    if (dx > 0) {
      // The upper edge itself belongs to the next row: a column that begins right there isn't
      // reached in this one.
      visit(row, at_lower_edge, at_upper_edge - (!ends_here && remainder == 0 ? 1 : 0));
    } else {
      visit(row, at_upper_edge, at_lower_edge);
    }
    at_lower_edge = at_upper_edge;
    to_next_edge();
  }
}

}  // namespace loopstone
