#pragma once

#include <Eigen/Core>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/registration/scan_matcher.hpp"

namespace loopstone {

/// What becomes of the source's surfaces at a pose, by weight. Together they are the whole source.
struct Agreement {
  double explained = 0.0;     ///< lie on a surface of the target that faces the same way
  double mismatched = 0.0;    ///< have such a surface near, but not on it
  double contradicted = 0.0;  ///< lie where a beam of the target passed
  double hidden = 0.0;        ///< where the target couldn't see

  [[nodiscard]] double total() const { return explained + mismatched + contradicted + hidden; }
  /// Of what the target could see.
  [[nodiscard]] double visible() const { return explained + mismatched + contradicted; }
};

/// Normal equations of point-to-line distances at a pose: H = sum w J^T J, g = sum w J^T r, J = dr
/// / d(x, y, yaw).
struct ScanEquations {
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  double squared_sum = 0.0;  ///< of w r^2
  double weight_sum = 0.0;
  int pairs = 0;
  Agreement agreement{};
};

/// Which surfaces take part, and how far off they may be.
struct FitScale {
  std::size_t stride = 1;  ///< every stride-th surface of the source
  double width_m = 0.03;   ///< of the Cauchy kernel
};

/// Pairs every surface of the source with the nearest one of those that the target's lidar sees in
/// about that direction.
///
///   r = n_j^T (T p_i - m_j),   w = w_i w_j / (1 + (r / width)^2)
///
/// Cost: O(surfaces), without search.
[[nodiscard]] ScanEquations scan_equations(const ScanView& source, const ScanView& target,
                                           const Pose2& target_T_source, const FitScale& scale);

/// What the final pairs know about (x, y, yaw).
struct ScanKnowledge {
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();  ///< sum w J^T J
  Eigen::Matrix3d noise =
      Eigen::Matrix3d::Zero();  ///< sum w^2 var(r) J^T J, covariance of the gradient
  Eigen::Vector2d centre{0.0,
                         0.0};  ///< of the paired points, from the source's origin, target axes [m]
  double arm_m = 1.0;           ///< their typical distance from it
};

/// Every return of both scans counts once, however many fitted lines it takes part in; the noise of
/// one range is told from the residuals.
[[nodiscard]] ScanKnowledge scan_knowledge(const ScanView& source, const ScanView& target,
                                           const Pose2& target_T_source, const FitScale& scale);

}  // namespace loopstone
