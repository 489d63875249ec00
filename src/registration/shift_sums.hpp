#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/grid/max_pyramid.hpp"

namespace loopstone {

/// Sums of neighbouring blocks of shifts in one row.
using LaneSums = std::array<std::int32_t, MaxPyramid::kLanes>;

/// Cells of a scan at one heading, as one array a coordinate.
struct CellList {
  std::vector<std::int32_t> columns{};
  std::vector<std::int32_t> rows{};

  [[nodiscard]] std::size_t size() const { return columns.size(); }
};

/// Where the rows of a pyramid's level begin in memory, for every row that a search can ask for: a
/// look-up in place of a test whether the row is inside.
class RowTable {
 public:
  /// \param reach  rows up to this far from the level's are asked for
  RowTable(const MaxPyramid::Level& level, int reach)
      : first_(level.lowest_row - 1 - reach), last_(level.highest_row + 1 + reach) {
    const int count = last_ - first_ + 1;
    offsets_.reserve(static_cast<std::size_t>(count));
    for (int row = first_; row <= last_; ++row) offsets_.push_back(level.row_offset(row));
    lowest_ = level.lowest_row - 1;
    highest_ = level.highest_row + 1;
    reach_ = reach;
  }

  /// The index of a row that will be shifted by [0, reach].
  [[nodiscard]] std::int32_t index_of(int row) const {
    return std::clamp(row, lowest_ - reach_, highest_) - first_;
  }
  [[nodiscard]] const std::uint32_t* data() const { return offsets_.data(); }

 private:
  int first_;
  int last_;
  int lowest_ = 0;
  int highest_ = 0;
  int reach_ = 0;
  std::vector<std::uint32_t> offsets_{};
};

/// A scan at one heading laid over one level of a pyramid, ready to be summed for many shifts.
class ScanOnLevel {
 public:
  ScanOnLevel(const MaxPyramid::Level& level, const RowTable& rows)
      : level_(&level), rows_(&rows) {}

  /// \param column, row  the shift that further shifts are counted from
  void lay(const CellList& cells, int column, int row);

  /// Chooses the kLanes blocks that begin `blocks` blocks (of 2^level columns) to the right.
  void choose_lanes(int blocks);

  /// The sums of the chosen blocks for cells [begin, end), `row_shift` rows further up, added to
  /// `sums`. No more than kMaxCells cells at once.
  static constexpr std::size_t kMaxCells = 256;
  void add(int row_shift, std::size_t begin, std::size_t end, LaneSums& sums) const;

 private:
  const MaxPyramid::Level* level_;
  const RowTable* rows_;
  std::vector<std::uint32_t> run_offsets_{};
  std::vector<std::int32_t> lane_indexes_{};
  std::vector<std::int32_t> row_indexes_{};
  std::vector<std::uint32_t> offsets_{};
};

}  // namespace loopstone
