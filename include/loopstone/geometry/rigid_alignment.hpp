#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cassert>
#include <span>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/geometry/pose3.hpp"

namespace loopstone {

/// The proper rotation and the translation that bring source points closest to their partners:
/// minimise sum_i w_i |R p_i + t - q_i|^2.
template <int kDimension>
struct RigidAlignment {
  Eigen::Matrix<double, kDimension, kDimension> rotation =
      Eigen::Matrix<double, kDimension, kDimension>::Identity();
  Eigen::Matrix<double, kDimension, 1> translation = Eigen::Matrix<double, kDimension, 1>::Zero();
  /// False when the points leave a rotation open: all in one place, in 3D also all on a line, or no
  /// pairs. The rotation is then one of the many best ones.
  bool unique = false;
};

/// Closed form by the singular value decomposition of the cross-covariance; a reflection is never
/// returned.
///
/// \param source,target  as many of one as of the other
/// \param weights        one a pair, not negative; empty: all 1
/// Cost: O(points). Source: Kabsch 1976; Umeyama 1991, eq. 39-42.
template <int kDimension>
[[nodiscard]] RigidAlignment<kDimension> align_rigidly(
    std::span<const Eigen::Matrix<double, kDimension, 1>> source,
    std::span<const Eigen::Matrix<double, kDimension, 1>> target,
    std::span<const double> weights = {}) {
  using Vector = Eigen::Matrix<double, kDimension, 1>;
  using Matrix = Eigen::Matrix<double, kDimension, kDimension>;
  assert(source.size() == target.size());
  assert(weights.empty() || weights.size() == source.size());
  const auto weight_of = [&](std::size_t i) { return weights.empty() ? 1.0 : weights[i]; };

  double total = 0.0;
  Vector source_mean = Vector::Zero();
  Vector target_mean = Vector::Zero();
  for (std::size_t i = 0; i < source.size(); ++i) {
    total += weight_of(i);
    source_mean += weight_of(i) * source[i];
    target_mean += weight_of(i) * target[i];
  }
  RigidAlignment<kDimension> result;
  if (!(total > 0.0)) return result;
  source_mean /= total;
  target_mean /= total;

  Matrix cross = Matrix::Zero();
  for (std::size_t i = 0; i < source.size(); ++i) {
    cross += weight_of(i) * (target[i] - target_mean) * (source[i] - source_mean).transpose();
  }
  const Eigen::JacobiSVD<Matrix> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const bool reflected = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0;
  Vector signs = Vector::Ones();
  if (reflected) signs(kDimension - 1) = -1.0;
  result.rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  result.translation = target_mean - result.rotation * source_mean;
  // The best rotation is unique when the two smallest singular values, the last with its sign, do
  // not cancel.
  const auto& values = svd.singularValues();
  const double open = values(kDimension - 2) + signs(kDimension - 1) * values(kDimension - 1);
  result.unique = open > 1e-12 * values(0) && values(0) > 0.0;
  return result;
}

[[nodiscard]] inline Pose2 to_pose(const RigidAlignment<2>& alignment) {
  return {alignment.translation.x(), alignment.translation.y(),
          wrap_angle(std::atan2(alignment.rotation(1, 0), alignment.rotation(0, 0)))};
}

[[nodiscard]] inline Pose3 to_pose(const RigidAlignment<3>& alignment) {
  return {alignment.translation, Eigen::Quaterniond(alignment.rotation).normalized()};
}

}  // namespace loopstone
