#include "loopstone/geometry/covariance.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/symmetric_matrix.hpp"

namespace loopstone {

Eigen::Matrix3d square_root(const Eigen::Matrix3d& covariance) {
  const SymmetricEigen<double, 3> axes = symmetric_eigen(covariance);
  return axes.vectors * axes.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

double largest_sigma(const Eigen::Matrix2d& covariance) {
  const SymmetricEigen<double, 2> axes = symmetric_eigen(covariance);
  return std::sqrt(std::max(axes.values(1), 0.0));
}

}  // namespace loopstone
