#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <span>

#include "graph/front_kernels.hpp"
#include "graph/front_tree.hpp"

namespace loopstone {

/// Where the block (row, column) of a front's pivot column begins in its panel; row and column are
/// places.
[[nodiscard]] inline std::size_t panel_offset(const Front& front, int row, int column) {
  std::size_t position = 0;
  if (row < front.first_pivot + front.pivots) {
    position = static_cast<std::size_t>(row - front.first_pivot);
  } else {
    const auto found = std::lower_bound(front.rows.begin(), front.rows.end(), row);
    position = static_cast<std::size_t>(front.pivots) +
               static_cast<std::size_t>(found - front.rows.begin());
  }
  const auto pivot = static_cast<std::size_t>(column - front.first_pivot);
  return 3 * pivot * padded_rows(3 * static_cast<std::size_t>(front.size())) + 3 * position;
}

/// Sets panel and update to zero.
inline void clear(const DenseFront& front) {
  const std::size_t below = front.rows - front.pivots;
  std::fill_n(front.panel, front.pivots * padded_rows(front.rows), 0.0);
  std::fill_n(front.update, below * padded_rows(below), 0.0);
}

template <typename Block>
inline void add_block(const Block& block, double* target, std::size_t stride) {
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) target[row] += block(row, column);
    target += stride;
  }
}

/// Adds what is left of a child (its update matrix, lower triangle of blocks) to its parent.
/// "Extend-add".
inline void add_update(std::span<const RowRun> runs, const DenseFront& child,
                       const DenseFront& parent) {
  const std::size_t child_stride = padded_rows(child.rows - child.pivots);
  const std::size_t panel_stride = padded_rows(parent.rows);
  const std::size_t update_stride = padded_rows(parent.rows - parent.pivots);
  for (std::size_t r = 0; r < runs.size(); ++r) {
    for (int i = 0; i < runs[r].length; ++i) {
      const auto here = 3 * static_cast<std::size_t>(runs[r].here + i);
      const auto there = 3 * static_cast<std::size_t>(runs[r].in_parent + i);
      const bool pivot = there < parent.pivots;
      for (std::size_t k = 0; k < 3; ++k) {
        const double* source = child.update + (here + k) * child_stride;
        double* target =
            pivot ? parent.panel + (there + k) * panel_stride
                  : parent.update + (there + k - parent.pivots) * update_stride - parent.pivots;
        // The rest of this run, from the diagonal on; then the runs below.
        const std::size_t first = 3 * static_cast<std::size_t>(runs[r].length - i);
        for (std::size_t n = 0; n < first; ++n) target[there + n] += source[here + n];
        for (std::size_t s = r + 1; s < runs.size(); ++s) {
          const double* from = source + 3 * static_cast<std::size_t>(runs[s].here);
          double* to = target + 3 * static_cast<std::size_t>(runs[s].in_parent);
          const auto count = 3 * static_cast<std::size_t>(runs[s].length);
          for (std::size_t n = 0; n < count; ++n) to[n] += from[n];
        }
      }
    }
  }
}

}  // namespace loopstone
