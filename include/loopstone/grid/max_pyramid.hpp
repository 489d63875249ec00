#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "loopstone/grid/grid.hpp"

namespace loopstone {

/// Upper bounds over windows of a grid: level k holds, at every cell, the largest value among the
/// 2^k x 2^k cells that start there and grow in column and row. Cells outside the grid have the
/// value `outside`.
///
/// The bounds of windows that stand side by side, 2^k columns apart, are neighbours in memory: each
/// row of level k is kept as 2^k runs, one for each remainder of the column by 2^k. A search reads
/// kLanes of them at once.
///
/// Memory: about one byte a cell and level. Cost to build: O(cells * levels), about 0.1 ns a cell
/// and level.
/// Source: Hess et al. 2016, "Real-time loop closure in 2D LIDAR SLAM", section V-B.
class MaxPyramid {
 public:
  /// As many windows side by side can be read at once, wherever they start.
  static constexpr int kLanes = 16;

  /// One level as it lies in memory. The bound of the window that starts at (column, row) is at
  ///   data[row_offset(row) + run_offset(column) + lane_index(column)],
  /// and those of the next kLanes - 1 windows to the right follow it.
  struct Level {
    int level = 0;
    std::uint32_t run_length = 0;  ///< with the entries of `outside` before each run
    std::uint32_t pitch = 0;       ///< from row to row
    int lowest_index = 0;          ///< lane indexes below and above are outside
    int highest_index = 0;
    int lowest_row = 0;  ///< rows below and above are outside
    int highest_row = 0;
    std::vector<std::uint8_t> data{};  ///< the first row of memory is all outside

    [[nodiscard]] std::uint32_t row_offset(int row) const {
      if (row < lowest_row || row > highest_row) return 0;
      return static_cast<std::uint32_t>(row - lowest_row + 1) * pitch;
    }
    [[nodiscard]] std::uint32_t run_offset(int column) const {
      return static_cast<std::uint32_t>(column & ((1 << level) - 1)) * run_length;
    }
    /// \param index  column / 2^level, rounded down
    [[nodiscard]] std::uint32_t lane_offset(int index) const {
      return static_cast<std::uint32_t>(
          std::clamp(index, lowest_index - kLanes, highest_index + 1) - lowest_index + kLanes);
    }
  };

  /// \param levels  at least 1; level 0 is the grid itself
  MaxPyramid(const Grid<std::uint8_t>& grid, int levels, std::uint8_t outside);

  [[nodiscard]] int level_count() const { return static_cast<int>(levels_.size()); }
  [[nodiscard]] const Level& level(int index) const {
    return levels_[static_cast<std::size_t>(index)];
  }
  /// Resolution and origin of the grid that it was built from; cells are counted in it.
  [[nodiscard]] const GridFrame& frame() const { return frame_; }
  /// Bytes of all levels.
  [[nodiscard]] std::size_t memory_bytes() const;

  /// The largest value in the window of 2^level cells that starts at (column, row), which may lie
  /// outside.
  [[nodiscard]] std::uint8_t bound(int level, int column, int row) const {
    const Level& at = levels_[static_cast<std::size_t>(level)];
    return at.data[at.row_offset(row) + at.run_offset(column) + at.lane_offset(column >> level)];
  }

 private:
  GridFrame frame_;
  std::vector<Level> levels_{};
};

}  // namespace loopstone
