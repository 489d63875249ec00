#pragma once

#include <Eigen/Core>

#include "loopstone/geometry/rigid_motion.hpp"

namespace loopstone {

/// Which small motions a set of residuals observes: the information matrix of the motion about a
/// centre, with turns in units of a typical arm so that metres compare with metres, in its
/// eigenbasis.
/// Source: Zhang, Kaess and Singh 2016, "On degeneracy of optimization-based state estimation
/// problems".
template <int kDimension>
struct Observability {
  static constexpr int kDof = RigidMotion<kDimension>::kDof;
  using Tangent = typename RigidMotion<kDimension>::Tangent;
  using Matrix = Eigen::Matrix<double, kDof, kDof>;

  Matrix directions;    ///< columns: unit motions, scaled coordinates
  Tangent information;  ///< of each, ascending [1/m^2 before the division by sigma^2]
  Eigen::Array<bool, kDof, 1> observed;
  Matrix to_scaled;  ///< from the small motion of the pose to the scaled one about the centre
  Matrix from_scaled;

  [[nodiscard]] bool complete() const { return observed.all(); }
  /// What is left of a motion without its unobserved parts.
  [[nodiscard]] Tangent observed_part(const Tangent& motion) const;
  /// The step that the information and a gradient give, none along unobserved directions.
  [[nodiscard]] Tangent solve(const Tangent& gradient) const;
  /// inverse(information) * noise * inverse(information) along observed directions, a large
  /// variance along the others. With noise = sigma^2 * information this is sigma^2 *
  /// inverse(information).
  [[nodiscard]] Matrix covariance(const Matrix& noise) const;
};

/// \param information  of the small motion of target_T_source: turns are about the origin of the
///                     source frame
/// \param centre       about which turns are judged, relative to that origin, target axes [m]
/// \param arm_m        typical distance of points from the centre, > 0
template <int kDimension>
[[nodiscard]] Observability<kDimension> observability_of(
    const typename Observability<kDimension>::Matrix& information,
    const typename RigidMotion<kDimension>::Vector& centre, double arm_m);

extern template struct Observability<2>;
extern template struct Observability<3>;

/// Standard deviation along an unobserved direction [m, or rad times the arm].
inline constexpr double kUnobservedSigmaM = 10.0;

}  // namespace loopstone
