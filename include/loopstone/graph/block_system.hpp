#pragma once

#include <Eigen/Core>
#include <memory>
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

/// The zero matrix with room for the blocks (row, column) and (column, row) of the pairs. Pairs may
/// repeat.
[[nodiscard]] BlockMatrix block_matrix(int size, std::vector<std::pair<int, int>> pairs);

/// y = A x; both have one vector for each block of the diagonal. Cost: O(blocks).
void multiply(const BlockMatrix& a, std::span<const Eigen::Vector3d> x,
              std::span<Eigen::Vector3d> y);

/// An order of elimination with little fill: result[i] is the place of i. Nodes of at most two
/// neighbours, the long chains of a pose graph, go first, in rounds of nodes that do not touch one
/// another, so that the elimination tree stays shallow; what is left is ordered by approximate
/// minimum degree (Amestoy, Davis and Duff 1996). Pairs may repeat and may join a node to itself.
[[nodiscard]] std::vector<int> fill_reducing_order(int size,
                                                   std::span<const std::pair<int, int>> pairs);

/// Solves A x = b for symmetric positive definite block matrices of one pattern, by a multifrontal
/// Cholesky factorisation. The pattern of the factor is found once; a matrix of the same pattern is
/// factorised again without any bookkeeping. Deterministic. Not thread-safe. Source: Duff and Reid
/// 1983; Liu 1992.
class BlockSolver {
 public:
  /// Eliminates the blocks in their order (see fill_reducing_order); the values are not looked at.
  explicit BlockSolver(const BlockMatrix& pattern);
  ~BlockSolver();
  BlockSolver(BlockSolver&&) noexcept;
  BlockSolver& operator=(BlockSolver&&) noexcept;

  /// \param a  of the pattern that the solver was made for
  /// False when it is not positive definite; then there is nothing to solve with.
  [[nodiscard]] bool factorise(const BlockMatrix& a);
  /// b becomes x. Only after factorise() returned true. Cost: O(blocks of the factor).
  void solve_in_place(std::span<Eigen::Vector3d> b);
  /// Noise of unit covariance becomes noise of covariance A^-1. As solve_in_place(), at half the
  /// cost.
  void colour_in_place(std::span<Eigen::Vector3d> z);

  /// Three rows that are zero but for the columns of one block.
  struct RowsAt {
    int block = 0;
    Eigen::Matrix3d rows;
  };
  /// J A^-1 J^T, J being the sum of the rows. Only after factorise() returned true. Reads what lies
  /// between the blocks of J and the root of the elimination tree.
  [[nodiscard]] Eigen::Matrix3d through_inverse(std::span<const RowsAt> j);

 private:
  struct Factor;
  std::unique_ptr<Factor> factor_;
};

}  // namespace loopstone
