#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "loopstone/grid/block_grid.hpp"

namespace loopstone {

/// Items with a `position`, in the order of the cells that they lie in (in a cell: as given), to be
/// found by place.
template <typename Item>
class CellRuns {
 public:
  CellRuns(std::vector<Item> items, double cell_m) : items_(std::move(items)), grid_(cell_m) {
    const auto before = [&](const Item& a, const Item& b) {
      const Cell cell_a = cell_of(a.position);
      const Cell cell_b = cell_of(b.position);
      return cell_a.row != cell_b.row ? cell_a.row < cell_b.row : cell_a.column < cell_b.column;
    };
    std::stable_sort(items_.begin(), items_.end(), before);
    for (std::size_t i = 0; i < items_.size(); ++i) {
      Run& run = grid_.at(cell_of(items_[i].position));
      if (run.end == 0) run.first = i;
      run.end = i + 1;
    }
  }

  [[nodiscard]] const std::vector<Item>& items() const { return items_; }
  /// Of an item that a visit was called with, its place in items().
  [[nodiscard]] std::size_t index_of(const Item& item) const {
    return static_cast<std::size_t>(&item - items_.data());
  }
  [[nodiscard]] Cell cell_of(const Eigen::Vector2f& point) const {
    return grid_.cell_of(static_cast<double>(point.x()), static_cast<double>(point.y()));
  }
  /// Calls visit(item) for the items of a cell.
  template <typename Visit>
  void for_each_in(Cell cell, Visit&& visit) const {
    const Run* run = grid_.find(cell);
    if (run == nullptr) return;
    for (std::size_t i = run->first; i < run->end; ++i) visit(items_[i]);
  }
  /// The same for all cells within `reach` cells.
  template <typename Visit>
  void for_each_around(Cell centre, int reach, Visit&& visit) const {
    for (int row = centre.row - reach; row <= centre.row + reach; ++row) {
      for (int column = centre.column - reach; column <= centre.column + reach; ++column)
        for_each_in({column, row}, visit);
    }
  }

 private:
  struct Run {
    std::size_t first = 0;
    std::size_t end = 0;
  };
  std::vector<Item> items_;
  BlockGrid<Run> grid_;
};

}  // namespace loopstone
