#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "graph/normal_equations.hpp"

namespace loopstone {

/// Powell's dogleg: steps within a trust region, along steepest descent and then towards the Newton
/// step. Lengths are measured in units of the Hessian's diagonal, so metres and radians need no
/// common scale.
/// Source: Powell 1970, "A new algorithm for unconstrained optimization"; Nocedal and Wright 2006,
/// section 4.1.
class Dogleg {
 public:
  /// Takes over the Newton step at the current state.
  void linearise(const NormalEquations& equations, std::span<const Eigen::Vector3d> newton_step);

  /// The step for the current radius; returns the decrease of the cost that it promises.
  [[nodiscard]] double choose_step(std::span<Eigen::Vector3d> step);
  [[nodiscard]] bool is_newton_step() const { return is_newton_step_; }

  /// \param gain  decrease over promised decrease
  void adapt(double gain);
  [[nodiscard]] bool exhausted() const { return radius_ < 1e-12; }

 private:
  double radius_ = 1e6;  ///< [standard deviations of a coordinate, others held]
  double step_length_ = 0.0;
  bool is_newton_step_ = false;
  std::vector<Eigen::Vector3d> newton_;
  std::vector<Eigen::Vector3d> cauchy_;  ///< the least point along steepest descent
  double newton_length_ = 0.0;
  double cauchy_length_ = 0.0;
  double dot_ = 0.0;  ///< of the two
  /// g^T s and s^T H s of the model, for s = newton, cauchy, and both.
  double gradient_newton_ = 0.0;
  double gradient_cauchy_ = 0.0;
  double curvature_newton_ = 0.0;
  double curvature_cauchy_ = 0.0;
  double curvature_both_ = 0.0;
};

}  // namespace loopstone
