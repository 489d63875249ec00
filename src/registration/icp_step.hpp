#pragma once

#include <Eigen/Core>
#include <span>

#include "registration/icp_pairs.hpp"
#include "registration/observability.hpp"

namespace loopstone {

/// The normal equations of a set of pairs in the small motion of target_T_source, and how the pairs
/// lie.
template <int kDimension>
struct IcpEquations {
  using Tangent = typename RigidMotion<kDimension>::Tangent;
  using Vector = typename RigidMotion<kDimension>::Vector;
  static constexpr int kDof = RigidMotion<kDimension>::kDof;

  Eigen::Matrix<double, kDof, kDof> information = Eigen::Matrix<double, kDof, kDof>::Zero();
  Tangent gradient = Tangent::Zero();
  Vector centre = Vector::Zero();  ///< of the pairs' arms
  double arm_m = 0.0;  ///< their root mean square distance from the centre, at least a trifle

  [[nodiscard]] Observability<kDimension> observability() const {
    return observability_of<kDimension>(information, centre, arm_m);
  }
};

/// The metric's normal equations: information = sum_i w_i J_i^T J_i and gradient = sum_i w_i J_i^T
/// r_i (half of the cost's derivative), weights held.
template <int kDimension>
[[nodiscard]] IcpEquations<kDimension> equations_of(std::span<const IcpPair<kDimension>> pairs,
                                                    IcpMetric metric);

/// Fills in centre and arm_m from the pairs that have weight.
template <int kDimension>
void set_extent(IcpEquations<kDimension>& equations, std::span<const IcpPair<kDimension>> pairs);

/// The pose after one step: closed form for the metrics point and line, Gauss-Newton for the others
/// and wherever a direction is unobserved; along that the pose stays.
template <int kDimension>
[[nodiscard]] typename RigidMotion<kDimension>::Pose step(
    std::span<const IcpPair<kDimension>> pairs, IcpMetric metric,
    const typename RigidMotion<kDimension>::Pose& target_T_source, double longest_step_m);

}  // namespace loopstone
