#pragma once

#include <Eigen/Core>

namespace loopstone {

/// The covariance (or information) of a pose (x, y, yaw) on other axes: R C R^T with R =
/// diag(b_R_a, 1). The yaw's own variance stays.
/// \param covariance  on axes a [m^2, m rad, rad^2]
/// \param b_R_a       the rotation that turns vectors from axes a to b, such as Pose2::rotation()
[[nodiscard]] inline Eigen::Matrix3d rotated(const Eigen::Matrix3d& covariance,
                                             const Eigen::Matrix2d& b_R_a) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = b_R_a;
  return turn * covariance * turn.transpose();
}

/// What a small motion (x, y, yaw) of a body does to its point at `arm`.
[[nodiscard]] inline Eigen::Matrix3d lever_of(const Eigen::Vector2d& arm) {
  Eigen::Matrix3d lever = Eigen::Matrix3d::Identity();
  lever(0, 2) = -arm.y();
  lever(1, 2) = arm.x();
  return lever;
}

/// A matrix whose product with its transpose is the given symmetric positive semidefinite one,
/// which may be singular; negative eigenvalues of rounding count as zero.
[[nodiscard]] Eigen::Matrix3d square_root(const Eigen::Matrix3d& covariance);

/// Standard deviation along the axis on which it is largest, in the unit of the covariance's root.
[[nodiscard]] double largest_sigma(const Eigen::Matrix2d& covariance);

}  // namespace loopstone
