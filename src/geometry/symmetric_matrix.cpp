#include "geometry/symmetric_matrix.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace loopstone {

template <typename Scalar, int kSize>
SymmetricEigen<Scalar, kSize> symmetric_eigen(const Eigen::Matrix<Scalar, kSize, kSize>& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<Scalar, kSize, kSize>> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template <typename Scalar, int kSize>
Eigen::Matrix<Scalar, kSize, 1> solve_symmetric(const Eigen::Matrix<Scalar, kSize, kSize>& matrix,
                                                const Eigen::Matrix<Scalar, kSize, 1>& right) {
  return matrix.ldlt().solve(right);
}

Eigen::Matrix3d inverse_symmetric(const Eigen::Matrix3d& matrix) {
  return matrix.ldlt().solve(Eigen::Matrix3d::Identity());
}

template SymmetricEigen<double, 1> symmetric_eigen(const Eigen::Matrix<double, 1, 1>&);
template SymmetricEigen<double, 2> symmetric_eigen(const Eigen::Matrix<double, 2, 2>&);
template SymmetricEigen<double, 3> symmetric_eigen(const Eigen::Matrix<double, 3, 3>&);
template SymmetricEigen<double, 6> symmetric_eigen(const Eigen::Matrix<double, 6, 6>&);

template Eigen::Vector2d solve_symmetric(const Eigen::Matrix2d&, const Eigen::Vector2d&);
template Eigen::Vector3d solve_symmetric(const Eigen::Matrix3d&, const Eigen::Vector3d&);
template Eigen::Vector4d solve_symmetric(const Eigen::Matrix4d&, const Eigen::Vector4d&);
template Eigen::Matrix<double, 6, 1> solve_symmetric(const Eigen::Matrix<double, 6, 6>&,
                                                     const Eigen::Matrix<double, 6, 1>&);
template Eigen::Vector3f solve_symmetric(const Eigen::Matrix3f&, const Eigen::Vector3f&);
template Eigen::Matrix<float, 6, 1> solve_symmetric(const Eigen::Matrix<float, 6, 6>&,
                                                    const Eigen::Matrix<float, 6, 1>&);

}  // namespace loopstone
