#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "graph/front_kernels.hpp"
#include "graph/front_tree.hpp"
#include "loopstone/graph/block_system.hpp"

namespace loopstone {

/// A = L L^T for a symmetric positive definite block matrix. The pattern of L is found once, so a
/// matrix of the same pattern is factorised again without any bookkeeping or allocation.
/// Multifrontal: each supernode is a small dense matrix, and hands what is left of it to its parent
/// in the elimination tree. Duff and Reid 1983, "The multifrontal solution of indefinite sparse
/// symmetric linear equations"; Liu 1992.
class BlockCholesky {
 public:
  /// Finds the pattern of L, with the blocks eliminated in their order; the values are not looked
  /// at.
  explicit BlockCholesky(const BlockMatrix& pattern);

  /// Factorises A + damping * diag(A). False when that is not positive definite; then there is
  /// nothing to solve with.
  [[nodiscard]] bool factorise(const BlockMatrix& a, double damping);

  /// Solves A x = b.
  [[nodiscard]] std::vector<Eigen::Vector3d> solve(std::vector<Eigen::Vector3d> b);
  /// The same, b becoming x.
  void solve_in_place(std::span<Eigen::Vector3d> b);
  /// z becomes L^-T z: noise of unit covariance becomes noise of covariance A^-1.
  void colour_in_place(std::span<Eigen::Vector3d> z);

  using RowsAt = BlockSolver::RowsAt;
  /// J A^-1 J^T. Only what lies between the blocks of J and the root of the elimination tree is
  /// read.
  [[nodiscard]] Eigen::Matrix3d through_inverse(std::span<const RowsAt> j);

  /// Blocks below the diagonal of L, zeros of merged supernodes included.
  [[nodiscard]] std::size_t fill() const { return fill_; }

  [[nodiscard]] const FrontTree& tree() const { return tree_; }
  /// The factor of a front.
  [[nodiscard]] DenseFront dense_front(std::size_t front);

 private:
  /// Where a block of A goes.
  struct Entry {
    int source = 0;          ///< in BlockMatrix::below; -1 - i for diagonal block i
    std::size_t offset = 0;  ///< in the front's panel
    bool transposed = false;
  };
  void lay_out_fronts();
  void lay_out_entries(const BlockMatrix& pattern);
  [[nodiscard]] double* x_at(int place) { return x_.data() + 3 * static_cast<std::size_t>(place); }
  void put(std::span<const Eigen::Vector3d> b);
  void substitute_back();
  void take(std::span<Eigen::Vector3d> b);
  void assemble(std::size_t front, const BlockMatrix& a, double damping, const DenseFront& dense);

  FrontTree tree_;
  std::vector<std::size_t> panel_start_;   ///< of each front, in panels_
  std::vector<std::size_t> update_start_;  ///< of each front, in the stack of its depth's parity
  std::vector<std::size_t> entry_start_;   ///< of each front, in entries_
  std::vector<Entry> entries_;
  std::unique_ptr<double[]> panels_;  ///< not set to zero: each front clears its own
  std::array<std::unique_ptr<double[]>, 2> stacks_;
  std::vector<double> inverse_diagonal_;
  std::vector<double> x_;          ///< right-hand side and solution, by place
  std::vector<double> below_;      ///< the part of one front
  std::vector<std::size_t> path_;  ///< of through_inverse: the fronts that it reads
  std::size_t fill_ = 0;
};

}  // namespace loopstone
