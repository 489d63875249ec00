#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "loopstone/grid/grid.hpp"
#include "loopstone/grid/grid_cells.hpp"

namespace loopstone {

/// Cells that are near to each other, as one piece.
class CellPieces {
 public:
  /// \param marked  not 0: part of a piece
  /// \param reach   cells so many columns and rows apart hang together
  CellPieces(Grid<std::uint8_t> marked, int reach) : marked_(std::move(marked)), reach_(reach) {}

  /// Calls take(cells) for each piece, once.
  template <typename Take>
  void for_each(Take&& take) {
    for_each_cell(marked_.frame(), [&](Cell start) {
      if (marked_[start] == 0) return;
      std::vector<Cell> piece{start};
      marked_[start] = 0;
      for (std::size_t i = 0; i < piece.size(); ++i) gather(piece[i], piece);
      take(piece);
    });
  }

 private:
  void gather(Cell from, std::vector<Cell>& piece) {
    for (int row = from.row - reach_; row <= from.row + reach_; ++row) {
      for (int column = from.column - reach_; column <= from.column + reach_; ++column) {
        const Cell cell{column, row};
        if (marked_.value_or(cell, 0) == 0) continue;
        marked_[cell] = 0;
        piece.push_back(cell);
      }
    }
  }

  Grid<std::uint8_t> marked_;
  int reach_;
};

}  // namespace loopstone
