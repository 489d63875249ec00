#pragma once

#include <Eigen/Core>
#include <vector>

#include "graph/block_cholesky.hpp"

namespace loopstone {

/// The blocks of A^-1 where L has blocks: the diagonal and A's own pattern, among others. One pass
/// from the root of the elimination tree to its leaves, at about twice the cost of the
/// factorisation. Takahashi, Fagan and Chin 1973, "Formation of a sparse bus impedance matrix";
/// front by front as in Lin et al. 2011, "SelInv: an algorithm for selected inversion of a sparse
/// symmetric matrix".
class SelectedInverse {
 public:
  /// \param factor  holds a factor that succeeded; it is read here and its tree later, so it must
  ///                outlive this
  explicit SelectedInverse(BlockCholesky& factor);

  /// Block (row, column) of A^-1, in the numbering of A. It must lie within the pattern of L + L^T.
  [[nodiscard]] Eigen::Matrix3d block(int row, int column) const;

 private:
  const FrontTree& tree_;
  std::vector<Eigen::MatrixXd> columns_;  ///< of each front's pivots: rows of the front
};

}  // namespace loopstone
