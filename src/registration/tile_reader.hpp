#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "loopstone/grid/max_pyramid.hpp"
#include "registration/shift_sums.hpp"

namespace loopstone {

/// Blocks of shifts in a square, so many along each side, are summed at once.
inline constexpr int kTileSide = 4;
/// Of the blocks of a tile: row * kTileSide + column.
using TileSums = std::array<std::int32_t, kTileSide * kTileSide>;

/// The cells that the points of a scan may be kept as: those that a shift can bring onto the grid,
/// and one line around that stands for all beyond. Cells are counted from its corner.
struct CellArea {
  int first_column = 0;
  int first_row = 0;
  int columns = 0;
  int rows = 0;
  int half_cells = 0;  ///< shifts run over [-half_cells, half_cells]
};

/// \param side  of the largest blocks of shifts, in cells
[[nodiscard]] CellArea cell_area(const GridFrame& frame, int half_cells, int side);

/// One level of a pyramid, read four by four bounds at once. What is read often is laid out anew
/// first, so that the sixteen bounds of a point are neighbours in memory.
class TileReader {
 public:
  TileReader(const MaxPyramid::Level& level, const CellArea& area);

  /// Adds the bounds of the cells [begin, end) in the sixteen blocks of 2^level shifts the first of
  /// which begins at (column, row), counted from the lowest shift.
  /// \param cells  of the area
  void add(const CellList& cells, std::size_t begin, std::size_t end, int column, int row,
           TileSums& sums);
  /// The same of blocks that reach `margin` cells farther on every side; no more than half of their
  /// own side.
  void add_widened(const CellList& cells, std::size_t begin, std::size_t end, int column, int row,
                   int margin, TileSums& sums) const;

 private:
  void lay_out();
  void widened_from_level(const CellList& cells, std::size_t begin, std::size_t end, int column,
                          int row, int margin, TileSums& sums) const;
  void add_from_level(const CellList& cells, std::size_t begin, std::size_t end, int column,
                      int row, TileSums& sums) const;
  void add_from_tiles(const CellList& cells, std::size_t begin, std::size_t end, int column,
                      int row, TileSums& sums) const;

  const MaxPyramid::Level* level_;
  int first_column_;  ///< of the area, at the lowest shift
  int first_row_;
  /// Where the bound of a shifted cell lies: the sum of both.
  std::vector<std::uint32_t> column_offsets_{};
  std::vector<std::uint32_t> row_offsets_{};
  std::size_t tile_count_;
  std::size_t points_read_ = 0;
  /// The bounds of a window and of the three above it; those to the right follow.
  std::vector<std::array<std::uint8_t, kTileSide>> tiles_{};
};

}  // namespace loopstone
