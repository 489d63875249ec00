#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "loopstone/base/options.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/registration/match_result.hpp"
#include "loopstone/registration/surface_grid.hpp"
#include "loopstone/sensor/scan_points.hpp"

namespace loopstone {

struct GridMatchOptions {
  int max_iterations = 15;
  double kernel_width_m = 0.04;
  double residual_sigma_m = 0.04;
};

template <typename Visitor>
void visit_options(GridMatchOptions& options, Visitor&& visit) {
  visit("max_iterations", options.max_iterations, Range{1, 200},
        "Gauss-Newton steps on each level");
  visit(
      "kernel_width_m", options.kernel_width_m, Range{0.001, 1.0},
      "distances beyond this count less and less (Cauchy kernel); on coarser levels in proportion "
      "to the cell");
  visit("residual_sigma_m", options.residual_sigma_m, Range{0.001, 1.0},
        "uncertainty of one point's distance to its surface, with what neighbours share");
}

/// What is known about a pose before looking.
struct PosePrior2 {
  Pose2 target_T_source;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of (x, y, yaw) in the target frame
  /// Along a direction that the points leave open: true, it alone holds the pose there; false, it
  /// is a mere guess, and what little the points say counts beside it.
  bool holds_unobserved = true;
};

/// Aligns surface points to a surface grid: Gauss-Newton on point-to-line distances, coarse level
/// to fine, with a Cauchy kernel and an optional prior that holds what the points do not observe.
///
///   minimise  sum_i w_i rho(n_i^T (T p_i - m_i)) / sigma^2  +  (T - T_prior)^T Omega (T - T_prior)
///
/// with (m_i, n_i) the line of the cell that T p_i falls in.
///
/// \param source         points with normals, source frame [m]
/// \param guess          start; converges from about the coarsest cell's size and 15 deg
/// \param coarsest_level start there (0 = finest only)
/// \return target_T_source; score = share of the source's weight that lies within two kernel widths
///         of a surface facing the same way; covariance includes the prior. kTooFewPairs: fewer
///         than 10 points found a surface, the pose is the guess.
///         kDegenerate: the points leave a direction of translation open (corridor), only the prior
///                      holds it.
/// Cost: O(iterations * points). Deterministic. Thread-safe.
[[nodiscard]] MatchResult match_to_grid(std::span<const SurfacePoint> source,
                                        const SurfaceGrid& target, const Pose2& guess,
                                        const std::optional<PosePrior2>& prior,
                                        const GridMatchOptions& options,
                                        std::size_t coarsest_level);

}  // namespace loopstone
