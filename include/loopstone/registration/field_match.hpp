#pragma once

#include <Eigen/Core>
#include <span>

#include "loopstone/base/options.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/registration/likelihood_field.hpp"
#include "loopstone/registration/match_result.hpp"

namespace loopstone {

struct FieldMatchOptions {
  int max_iterations = 20;
  double kernel_width_m = 0.05;
  double point_sigma_m = 0.01;
};

template <typename Visitor>
void visit_options(FieldMatchOptions& options, Visitor&& visit) {
  visit("max_iterations", options.max_iterations, Range{1, 200},
        "Gauss-Newton steps on each level");
  visit(
      "kernel_width_m", options.kernel_width_m, Range{0.001, 1.0},
      "distances beyond this count less and less (Cauchy kernel); on coarser levels in proportion "
      "to the cell");
  visit("point_sigma_m", options.point_sigma_m, Range{1e-6, 1.0},
        "standard deviation of a point; the least that the covariance is computed with");
}

/// Aligns a scan to the walls of an occupancy grid: Gauss-Newton on the distances d to the nearest
/// wall, coarse level to fine, with a Cauchy kernel rho:
///
///   minimise  sum_i rho(d(T p_i)^2)
///
/// \param source          points, source frame [m]
/// \param guess           start; converges from about the coarsest level's reach and 10 to 20 deg
/// \param coarsest_level  start there (0 = finest only); more than the field has: its coarsest
/// \return target_T_source. score = share of the points within two kernel widths of a wall. The
///         covariance counts the error of a wall that is rounded to cells once for the whole wall,
///         not once for each point on it. kTooFewPairs: fewer than 10 points found a wall, the pose
///         is the guess. kDegenerate: a direction is unobserved (a corridor's axis); along it the
///         pose is the guess and the covariance is large.
/// Cost: O(iterations * points), about 15 ns a point. Deterministic. Thread-safe.
/// Source: Kohlbrecher et al. 2011, equations 4 to 14; degenerate directions as Zhang, Kaess and
/// Singh 2016.
[[nodiscard]] MatchResult match_to_field(std::span<const Eigen::Vector2d> source,
                                         const MapField& field, const Pose2& guess,
                                         const FieldMatchOptions& options = {},
                                         std::size_t coarsest_level = 2);

/// The cost above and its gradient by (x, y, yaw) at a pose, for tests and for drawing cost
/// surfaces.
struct FieldCost {
  double cost = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};
[[nodiscard]] FieldCost field_cost(std::span<const Eigen::Vector2d> source, const MapField& field,
                                   std::size_t level, const Pose2& target_T_source,
                                   double kernel_width_m);

}  // namespace loopstone
