#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/registration/match_result.hpp"
#include "loopstone/registration/point_index.hpp"

namespace loopstone {

struct IcpOptions {
  /// "point": distances to the nearest point; "line": to the line through it and its neighbours.
  std::string metric = "line";
  double max_pair_distance_m = 0.5;
  /// Only this share of the pairs, the closest ones, is used.
  double trim_fraction = 0.9;
  /// Residuals beyond count less and less (Cauchy kernel); 0: all alike.
  double kernel_width_m = 0.1;
  int max_iterations = 50;
  double tolerance_m = 1e-4;
  double tolerance_rad = 1e-4;
  /// Of one point; residuals smaller than this are not believed.
  double point_sigma_m = 0.02;
};

template <typename Visitor>
void visit_options(IcpOptions& options, Visitor&& visit) {
  visit("metric", options.metric, OneOf{{"point", "line"}},
        "distance to the nearest point, or to the line through it and its neighbours");
  visit("max_pair_distance_m", options.max_pair_distance_m, Range{0.001, 100.0},
        "pairs farther apart are ignored");
  visit("trim_fraction", options.trim_fraction, Range{0.05, 1.0},
        "share of the pairs, closest first, that is used");
  visit("kernel_width_m", options.kernel_width_m, Range{0.0, 100.0},
        "distances beyond this count less and less (Cauchy kernel); 0: all alike");
  visit("max_iterations", options.max_iterations, Range{1, 1000}, "stop after so many steps");
  visit("tolerance_m", options.tolerance_m, Range{1e-12, 1.0}, "a shorter step ends the search");
  visit("tolerance_rad", options.tolerance_rad, Range{1e-12, 1.0},
        "a smaller turn ends the search");
  visit("point_sigma_m", options.point_sigma_m, Range{1e-6, 1.0},
        "standard deviation of a point; the least that the covariance is computed with");
}

/// The reference that clouds are aligned to: points, indexed, and the normals of the lines they lie on.
struct IcpTarget {
  PointIndex<2> index;
  std::vector<std::optional<Eigen::Vector2d>> normals;
};

/// \param points  target frame [m]; those that are not finite are ignored
[[nodiscard]] IcpTarget make_icp_target(std::vector<Eigen::Vector2d> points);

/// Aligns a cloud to a reference by iterated closest points: pairs every source point with the nearest target point,
/// then moves the source to lower
///
///   point:  sum_i w_i |T p_i - q_i|^2            (closed form, Kabsch)
///   line:   sum_i w_i (n_i^T (T p_i - q_i))^2    (one Gauss-Newton step), with n_i the normal at q_i
///
/// until the steps are small. The farthest pairs are trimmed, the rest weighted by a Cauchy kernel.
///
/// \param source                 points in the source frame [m]
/// \param guess_target_T_source  start; converges from about max_pair_distance_m and 15 deg
/// \return target_T_source and its covariance. score = share of the source within 3 point_sigma_m of the target.
///         kTooFewPairs: fewer than 3 pairs, the pose is the guess. kDegenerate: a direction is unobserved (a corridor's
///         axis, a turn about a circle's centre); along it the pose is the guess and the covariance is large.
/// Cost: O(iterations * source * log target). Deterministic. Thread-safe.
/// Source: Besl and McKay 1992; Censi 2008, "An ICP variant using a point-to-line metric"; trimming of Chetverikov 2002;
/// remapping of degenerate directions of Zhang, Kaess and Singh 2016.
[[nodiscard]] MatchResult match_icp(std::span<const Eigen::Vector2d> source,
                                    const IcpTarget& target, const Pose2& guess_target_T_source,
                                    const IcpOptions& options = {});

}  // namespace loopstone
