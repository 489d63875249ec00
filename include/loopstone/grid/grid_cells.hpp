#pragma once

#include "loopstone/grid/grid_frame.hpp"

namespace loopstone {

/// Calls visit(cell) for each cell of a frame, row by row.
template <typename Visit>
void for_each_cell(const GridFrame& frame, Visit&& visit) {
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) visit(Cell{column, row});
  }
}

}  // namespace loopstone
