#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

namespace loopstone {

/// A symmetric matrix of 3x3 blocks: the diagonal, and what stands below it, column by column.
struct BlockMatrix {
  std::vector<int>
      column_start;       ///< where a column begins in `rows` and `below`; one more at the end
  std::vector<int> rows;  ///< ascending in each column, all greater than the column
  std::vector<Eigen::Matrix3d> diagonal;
  std::vector<Eigen::Matrix3d> below;
};

/// The zero matrix with room for the blocks (row, column) and (column, row) of the pairs. Pairs may repeat.
[[nodiscard]] BlockMatrix block_matrix(int size, std::vector<std::pair<int, int>> pairs);

/// An order of elimination with little fill: result[i] is the place of i. Approximate minimum degree
/// (Amestoy, Davis and Duff 1996) on the blocks.
[[nodiscard]] std::vector<int> fill_reducing_order(int size,
                                                   std::span<const std::pair<int, int>> pairs);

/// A = L L^T for a symmetric positive definite block matrix. The pattern of L is found once, so a matrix of the same
/// pattern is factorised again without any bookkeeping.
/// Left-looking by block columns: Davis 2006, "Direct methods for sparse linear systems", sections 4.1 and 4.8.
class BlockCholesky {
 public:
  /// Finds the pattern of L; the values are not looked at.
  explicit BlockCholesky(const BlockMatrix& pattern);

  /// Factorises A + damping * diag(A). False when that is not positive definite; then there is nothing to solve with.
  [[nodiscard]] bool factorise(const BlockMatrix& a, double damping);

  /// Solves A x = b.
  [[nodiscard]] std::vector<Eigen::Vector3d> solve(std::vector<Eigen::Vector3d> b) const;

  /// Blocks below the diagonal of L.
  [[nodiscard]] std::size_t fill() const { return rows_.size(); }

 private:
  /// Columns that still have to be subtracted from a later one: a linked list for each row that comes next.
  struct Pending {
    std::vector<int> first_of_row;
    std::vector<int> next;
    std::vector<int> position;
  };
  void defer(int column, int position);
  void subtract_pending(int column);
  [[nodiscard]] bool finish_column(int column);

  std::vector<int> column_start_;
  std::vector<int> rows_;
  std::vector<Eigen::Matrix3d> below_;
  std::vector<Eigen::Matrix3d> inverse_diagonal_;  ///< of L's diagonal blocks, lower triangular
  std::vector<Eigen::Matrix3d> work_;              ///< the column in the making, by row
  Pending pending_;
};

}  // namespace loopstone
