#pragma once

#include <Eigen/Core>

namespace loopstone {

// Eigen's decompositions of small matrices, compiled once: their templates take the compiler longer
// than the rest of most sources that need them. Sizes and scalars: see the list in
// symmetric_matrix.cpp.

template <typename Scalar, int kSize>
struct SymmetricEigen {
  Eigen::Matrix<Scalar, kSize, 1> values;  ///< ascending
  Eigen::Matrix<Scalar, kSize, kSize>
      vectors;  ///< in columns, of length 1, each with an arbitrary sign
};

/// \param matrix  only its lower triangle is read
template <typename Scalar, int kSize>
[[nodiscard]] SymmetricEigen<Scalar, kSize> symmetric_eigen(
    const Eigen::Matrix<Scalar, kSize, kSize>& matrix);

/// x with matrix * x = right, by LDL^T with pivoting (Eigen::LDLT); where the matrix is singular,
/// some x.
/// \param matrix  semidefinite; only its lower triangle is read
template <typename Scalar, int kSize>
[[nodiscard]] Eigen::Matrix<Scalar, kSize, 1> solve_symmetric(
    const Eigen::Matrix<Scalar, kSize, kSize>& matrix,
    const Eigen::Matrix<Scalar, kSize, 1>& right);

/// The inverse, in the same way.
[[nodiscard]] Eigen::Matrix3d inverse_symmetric(const Eigen::Matrix3d& matrix);

}  // namespace loopstone
