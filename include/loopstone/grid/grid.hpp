#pragma once

#include <cassert>
#include <vector>

#include "loopstone/grid/grid_frame.hpp"

namespace loopstone {

/// A dense array of cells, row-major from the lower left corner.
template <typename T>
class Grid {
 public:
  Grid() = default;
  explicit Grid(const GridFrame& frame, const T& value = T{})
      : frame_(frame), cells_(frame.cell_count(), value) {}

  [[nodiscard]] const GridFrame& frame() const { return frame_; }
  [[nodiscard]] const T& operator[](Cell cell) const {
    assert(frame_.contains(cell));
    return cells_[frame_.index_of(cell)];
  }
  [[nodiscard]] T& operator[](Cell cell) {
    assert(frame_.contains(cell));
    return cells_[frame_.index_of(cell)];
  }
  /// The cell's value, or `outside` beyond the edges.
  [[nodiscard]] T value_or(Cell cell, const T& outside) const {
    return frame_.contains(cell) ? cells_[frame_.index_of(cell)] : outside;
  }
  [[nodiscard]] const std::vector<T>& cells() const { return cells_; }
  [[nodiscard]] std::vector<T>& cells() { return cells_; }
  [[nodiscard]] bool empty() const { return cells_.empty(); }

  template <typename Archive>
  void archive(Archive& a) {
    a(frame_, cells_);
    a.check(cells_.size() == frame_.cell_count(), "a grid with too few or too many cells");
  }

 private:
  GridFrame frame_{};
  std::vector<T> cells_{};
};

}  // namespace loopstone
