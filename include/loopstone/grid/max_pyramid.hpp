#pragma once

#include <cstdint>
#include <vector>

#include "loopstone/grid/grid.hpp"

namespace loopstone {

/// Upper bounds over windows of a grid: level k holds, at every cell, the largest value among the 2^k x 2^k cells that
/// start there and grow in column and row. Cells outside the grid have the value `outside`.
/// Memory: one byte a cell and level. Cost to build: O(cells * levels).
/// Source: Hess et al. 2016, "Real-time loop closure in 2D LIDAR SLAM", section V-B.
class MaxPyramid {
 public:
  /// \param levels  at least 1; level 0 is the grid itself
  MaxPyramid(const Grid<std::uint8_t>& grid, int levels, std::uint8_t outside);

  [[nodiscard]] int level_count() const { return static_cast<int>(levels_.size()); }
  /// Resolution and origin of the grid that it was built from; cells are counted in it.
  [[nodiscard]] const GridFrame& frame() const { return frame_; }

  /// The largest value in the window of 2^level cells that starts at (column, row), which may lie outside.
  [[nodiscard]] std::uint8_t bound(int level, int column, int row) const {
    const auto c = static_cast<unsigned>(column + margin_);
    const auto r = static_cast<unsigned>(row + margin_);
    if (c >= columns_ || r >= rows_) return outside_;
    return levels_[static_cast<std::size_t>(level)][static_cast<std::size_t>(r) * columns_ + c];
  }

 private:
  GridFrame frame_;
  int margin_;  ///< cells added below and to the left, where windows reach into the grid from outside
  unsigned columns_;
  unsigned rows_;
  std::uint8_t outside_;
  std::vector<std::vector<std::uint8_t>> levels_{};
};

}  // namespace loopstone
