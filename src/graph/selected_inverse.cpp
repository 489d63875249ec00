#include "graph/selected_inverse.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "graph/ordered_product.hpp"

namespace loopstone {

namespace {

using Dense = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

/// The part of the parent's square that belongs to the rows of a front; both are symmetric.
Eigen::MatrixXd rows_of_parent(const Front& front, const Eigen::MatrixXd& parent) {
  Eigen::MatrixXd part(3 * front.below(), 3 * front.below());
  for (const RowRun& column : front.runs) {
    for (const RowRun& row : front.runs) {
      part.block(3 * row.here, 3 * column.here, 3 * row.length, 3 * column.length) =
          parent.block(3 * row.in_parent, 3 * column.in_parent, 3 * row.length, 3 * column.length);
    }
  }
  return part;
}

}  // namespace

SelectedInverse::SelectedInverse(BlockCholesky& factor) : tree_(factor.tree()) {
  const std::size_t count = tree_.fronts.size();
  columns_.resize(count);
  std::vector<Eigen::MatrixXd> squares(count);  // of A^-1, until the last child has taken its part
  std::vector<std::size_t> children_left(count);
  for (std::size_t f = count; f-- > 0;) {
    const Front& front = tree_.fronts[f];
    const DenseFront dense = factor.dense_front(f);
    const Eigen::Index pivots = 3 * front.pivots;
    const Eigen::Index below = 3 * front.below();
    const Dense panel(dense.panel, pivots + below, pivots,
                      Eigen::OuterStride<>(static_cast<Eigen::Index>(padded_rows(dense.rows))));
    const Eigen::MatrixXd inverse = inverse_of_lower(panel.topRows(pivots));
    Eigen::MatrixXd square = Eigen::MatrixXd::Zero(pivots + below, pivots + below);
    auto head = square.topLeftCorner(pivots, pivots);
    add_product(head, Eigen::MatrixXd(inverse.transpose()), inverse, 1.0);
    if (below > 0) {
      const auto parent = static_cast<std::size_t>(front.parent);
      square.bottomRightCorner(below, below) = rows_of_parent(front, squares[parent]);
      if (--children_left[parent] == 0) squares[parent].resize(0, 0);
      Eigen::MatrixXd through = Eigen::MatrixXd::Zero(below, pivots);
      add_product(through, panel.bottomRows(below), inverse, 1.0);
      auto left = square.bottomLeftCorner(below, pivots);
      add_product(left, square.bottomRightCorner(below, below), through, -1.0);
      add_product(head, Eigen::MatrixXd(through.transpose()), left, -1.0);
      square.topRightCorner(pivots, below) = left.transpose();
    }
    columns_[f] = square.leftCols(pivots);
    children_left[f] = static_cast<std::size_t>(std::count_if(
        front.children.begin(), front.children.end(),
        [this](int child) { return tree_.fronts[static_cast<std::size_t>(child)].below() > 0; }));
    if (children_left[f] > 0) squares[f] = std::move(square);
  }
}

Eigen::Matrix3d SelectedInverse::block(int row, int column) const {
  const int row_place = tree_.place[static_cast<std::size_t>(row)];
  const int column_place = tree_.place[static_cast<std::size_t>(column)];
  const auto f = static_cast<std::size_t>(
      tree_.front_of[static_cast<std::size_t>(std::min(row_place, column_place))]);
  const Front& front = tree_.fronts[f];
  const auto position = [&front](int place) {
    const int pivot = place - front.first_pivot;
    if (pivot < front.pivots) return pivot;
    const auto at = std::lower_bound(front.rows.begin(), front.rows.end(), place);
    return front.pivots + static_cast<int>(at - front.rows.begin());
  };
  const Eigen::Matrix3d block =
      columns_[f].block<3, 3>(3 * position(std::max(row_place, column_place)),
                              3 * position(std::min(row_place, column_place)));
  return row_place >= column_place ? block : Eigen::Matrix3d(block.transpose());
}

}  // namespace loopstone
