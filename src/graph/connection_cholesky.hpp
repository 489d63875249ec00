#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace loopstone {

/// Where a symmetric matrix of blocks and its Cholesky factor have blocks, in an order of
/// elimination with little fill. Found once, and used for matrices of different block sizes over
/// the same nodes.
struct EliminationPattern {
  std::vector<int> place;         ///< of a node in the order of elimination
  std::vector<int> column_start;  ///< of the factor's columns in `rows`; one more at the end
  std::vector<int> rows;          ///< ascending in each column, greater than the column

  [[nodiscard]] std::size_t size() const { return place.size(); }
  /// Index in `rows` of the block (row, column), both places, row > column. It has to be there.
  [[nodiscard]] std::size_t find(int row, int column) const;
};

/// \param pairs  nodes that a block joins; may repeat, in any order
[[nodiscard]] EliminationPattern elimination_pattern(int size,
                                                     std::span<const std::pair<int, int>> pairs);

/// A complex block with its real and imaginary parts apart, so that products are those of real
/// matrices.
template <int kSize>
struct ComplexBlock {
  using Real = Eigen::Matrix<double, kSize, kSize>;
  using Values = Eigen::Matrix<double, kSize, 2>;  ///< of a vector: real parts, imaginary parts

  Real re = Real::Zero();
  Real im = Real::Zero();
};

/// A real block.
template <int kSize>
struct RealBlock {
  using Real = Eigen::Matrix<double, kSize, kSize>;
  using Values = Eigen::Matrix<double, kSize, 1>;

  Real re = Real::Zero();
};

/// A Hermitian (or real symmetric) matrix of blocks, and then, in the same place, its factor: A = L
/// L^H. Blocks are addressed by places in the order of elimination. Left-looking by block columns:
/// Davis 2006, "Direct methods for sparse linear systems", sections 4.1 and 4.8.
template <typename Block>
class ConnectionCholesky {
 public:
  using Values = typename Block::Values;

  explicit ConnectionCholesky(const EliminationPattern& pattern);

  void set_zero();
  [[nodiscard]] Block& diagonal(int place) { return diagonal_[static_cast<std::size_t>(place)]; }
  [[nodiscard]] Block& below(std::size_t index) { return below_[index]; }
  [[nodiscard]] const EliminationPattern& pattern() const { return *pattern_; }

  /// Replaces the matrix by its factor. False when it is not positive definite; set the matrix anew
  /// then.
  [[nodiscard]] bool factorise();

  /// x of A x = b, by places, after factorise().
  void solve_in_place(std::vector<Values>& b) const;

 private:
  void defer(int column, int position);
  void subtract_pending(std::size_t column);
  [[nodiscard]] bool finish_column(std::size_t column);

  const EliminationPattern* pattern_;
  std::vector<Block> diagonal_;  ///< after factorise() the inverses of L's diagonal blocks
  std::vector<Block> below_;
  /// Columns that still have to be subtracted from a later one: a linked list for each row that
  /// comes next.
  std::vector<int> first_of_row_;
  std::vector<int> next_;
  std::vector<int> position_;
  std::vector<int> slot_;  ///< where the column in the making keeps a row
};

extern template class ConnectionCholesky<ComplexBlock<1>>;
extern template class ConnectionCholesky<ComplexBlock<2>>;
extern template class ConnectionCholesky<RealBlock<3>>;

}  // namespace loopstone
