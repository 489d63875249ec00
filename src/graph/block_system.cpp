#include "loopstone/graph/block_system.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "graph/block_cholesky.hpp"

namespace loopstone {

BlockMatrix block_matrix(int size, std::vector<std::pair<int, int>> pairs) {
  // Sorted by two counting passes: first by row, then by column, which keeps the rows in order.
  const auto columns = static_cast<std::size_t>(size);
  for (auto& [column, row] : pairs) {
    if (column > row) std::swap(column, row);
  }
  const auto counted = [&](auto key) {
    std::vector<std::size_t> start(columns + 1, 0);
    for (const auto& pair : pairs) ++start[static_cast<std::size_t>(key(pair)) + 1];
    for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
    std::vector<std::pair<int, int>> sorted(pairs.size());
    for (const auto& pair : pairs) sorted[start[static_cast<std::size_t>(key(pair))]++] = pair;
    pairs = std::move(sorted);
  };
  counted([](const std::pair<int, int>& pair) { return pair.second; });
  counted([](const std::pair<int, int>& pair) { return pair.first; });
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());

  BlockMatrix result;
  result.column_start.assign(columns + 1, 0);
  result.rows.reserve(pairs.size());
  for (const auto& [column, row] : pairs) {
    if (column == row) continue;
    ++result.column_start[static_cast<std::size_t>(column) + 1];
    result.rows.push_back(row);
  }
  for (std::size_t i = 1; i < result.column_start.size(); ++i) {
    result.column_start[i] += result.column_start[i - 1];
  }
  result.diagonal.assign(columns, Eigen::Matrix3d::Zero());
  result.below.assign(result.rows.size(), Eigen::Matrix3d::Zero());
  return result;
}

void multiply(const BlockMatrix& a, std::span<const Eigen::Vector3d> x,
              std::span<Eigen::Vector3d> y) {
  for (std::size_t i = 0; i < x.size(); ++i) y[i] = a.diagonal[i] * x[i];
  for (std::size_t column = 0; column < x.size(); ++column) {
    for (int k = a.column_start[column]; k < a.column_start[column + 1]; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const auto row = static_cast<std::size_t>(a.rows[at]);
      y[row] += a.below[at] * x[column];
      y[column] += a.below[at].transpose() * x[row];
    }
  }
}

struct BlockSolver::Factor {
  BlockCholesky cholesky;
};

BlockSolver::BlockSolver(const BlockMatrix& pattern)
    : factor_(std::make_unique<Factor>(Factor{BlockCholesky(pattern)})) {}
BlockSolver::~BlockSolver() = default;
BlockSolver::BlockSolver(BlockSolver&&) noexcept = default;
BlockSolver& BlockSolver::operator=(BlockSolver&&) noexcept = default;

bool BlockSolver::factorise(const BlockMatrix& a) { return factor_->cholesky.factorise(a, 0.0); }
void BlockSolver::solve_in_place(std::span<Eigen::Vector3d> b) {
  factor_->cholesky.solve_in_place(b);
}
void BlockSolver::colour_in_place(std::span<Eigen::Vector3d> z) {
  factor_->cholesky.colour_in_place(z);
}
Eigen::Matrix3d BlockSolver::through_inverse(std::span<const RowsAt> j) {
  return factor_->cholesky.through_inverse(j);
}

}  // namespace loopstone
