#pragma once

#include <Eigen/Core>
#include <span>

#include "loopstone/base/options.hpp"
#include "loopstone/base/robust_kernel.hpp"
#include "loopstone/registration/icp_cloud.hpp"
#include "loopstone/registration/match_result.hpp"

namespace loopstone {

/// The distance that is made small:
enum class IcpMetric {
  kPoint,  ///< to the nearest points,
  kLine,   ///< to the segments between them, in the plane alone,
  kPlane,  ///< to the lines or planes fitted around them,
  kGicp,   ///< or between planes of both clouds
};

constexpr auto words_of(IcpMetric /*any*/) {
  using enum IcpMetric;
  return std::array{Word{kPoint, "point"}, Word{kLine, "line"}, Word{kPlane, "plane"},
                    Word{kGicp, "gicp"}};
}

struct IcpOptions {
  IcpMetric metric = IcpMetric::kPlane;
  double max_pair_distance_m = 3.0;
  double final_pair_distance_m = 0.2;
  int shrink_iterations = 20;
  double trim_fraction = 0.9;
  RobustKernel kernel = RobustKernel::kCauchy;
  double kernel_width_m = 0.1;
  int max_iterations = 50;
  double tolerance_m = 1e-4;
  double tolerance_rad = 1e-4;
  double tolerance_cost = 0.002;
  double point_sigma_m = 0.02;
  double least_explained = 0.5;
};

template <typename Visitor>
void visit_options(IcpOptions& options, Visitor&& visit) {
  visit("metric", options.metric,
        "distance to the nearest point, to the segment between nearest points (in the plane), to "
        "the line or plane "
        "fitted around it, or between planes of both clouds");
  visit("max_pair_distance_m", options.max_pair_distance_m, Range{1e-6, 1e6},
        "pairs farther apart are ignored, at the start");
  visit("final_pair_distance_m", options.final_pair_distance_m, Range{0.0, 1e6},
        "the same in the end; 0: as at the start");
  visit("shrink_iterations", options.shrink_iterations, Range{1, 1000},
        "steps from the first pair distance to the last, fewer when they get short; the kernel's "
        "width shrinks alike");
  visit("trim_fraction", options.trim_fraction, Range{0.05, 1.0},
        "share of the pairs, closest first, that is used");
  visit("kernel", options.kernel, "how distances beyond its width count less");
  visit("kernel_width_m", options.kernel_width_m, Range{0.0, 1e6},
        "distances beyond this count less and less; 0: all alike");
  visit("max_iterations", options.max_iterations, Range{1, 1000}, "stop after so many steps");
  visit("tolerance_m", options.tolerance_m, Range{1e-12, 1.0}, "a shorter step ends the search");
  visit("tolerance_rad", options.tolerance_rad, Range{1e-12, 1.0},
        "a smaller turn ends the search");
  visit("tolerance_cost", options.tolerance_cost, Range{0.0, 1.0},
        "five steps that lower the residuals by a smaller share end the search");
  visit("point_sigma_m", options.point_sigma_m, Range{1e-9, 1e3},
        "standard deviation of a point; within three of it a point is explained");
  visit("least_explained", options.least_explained, Range{0.0, 1.0},
        "share of the points near the target that must be explained, else not_converged");
}

/// Aligns a cloud to a reference by iterated closest points, in the plane (kDimension 2) or in
/// space (3): pairs every source point p with the nearest target point q, then moves the source to
/// lower
///
///   point:  sum_i w_i |T p_i - q_i|^2              closed form (Kabsch 1976)
///   line: sum_i w_i (n_i^T (T p_i - q_i))^2 n_i the normal of the segment from q_i to its
///   neighbour on the side of
///                                                  T p_i; closed form (Censi 2008); in the plane
///                                                  only
///   plane: sum_i w_i (n_i^T (T p_i - m_i))^2 m_i, n_i of the line or plane fitted around q_i;
///   Gauss-Newton
///   gicp: sum_i w_i d_i^T M_i d_i, d_i = T p_i - q_i, M_i = 2 e (C_q + R C_p R^T)^-1, both
///   covariances 1 along the
///           surface and e = 0.001 across it (Segal 2009), scaled so that across two parallel
///           surfaces M_i is 1
///
/// until steps are small, or residuals no longer shrink. The farthest pairs are trimmed, the rest
/// weighted by the kernel.
///
/// \param source                 points in the source frame [m]; the metric kGicp uses their
///                               patches
/// \param guess_target_T_source  start; scans of rooms converge from about 0.4 m and 30 deg
/// \return target_T_source and its covariance. score = share of the source that is explained:
///         within 3 point_sigma_m of the target's surface. Overlapping is what has a target point
///         within max_pair_distance_m.
///         kTooFewPairs: fewer pairs than degrees of freedom, the pose is the guess.
///         kNotConverged: the iterations ran out, or less than least_explained of the overlapping
///                        part is explained: a
///         wrong minimum, as a rule.
///         kDegenerate: a direction is unobserved (a corridor's axis, a turn about a circle's
///                      centre): it has less than
///         1 % of the information of the best one, turns measured at the cloud's radius. Along it
///         the pose is the guess and the standard deviation 10 m.
/// The covariance is that of independent noise of both clouds, the source's estimated from the
/// residuals (their median, with the degrees of freedom taken off), the target's from the thickness
/// of its patches: H^-1 (s_p^2 sum_i w_i^2 J_i^T J_i + s_q^2 sum_j G_j^T G_j) H^-1, where G_j sums
/// w_i J_i of all source points that share target point j (Censi 2007, "An accurate closed-form
/// estimate of ICP's covariance"). It does not know of wrong pairs.
/// Throws UsageError for the metric kLine in space.
/// Cost: O(iterations * source * log target); while the nearest point can't have changed it is not
/// searched for (Greenspan and Godin 2001). Deterministic. Thread-safe.
/// Source: Besl and McKay 1992; Chen and Medioni 1992; trimming of Chetverikov 2002; remapping of
/// degenerate directions of Zhang, Kaess and Singh 2016.
template <int kDimension>
[[nodiscard]] BasicMatchResult<kDimension> match_icp(
    const IcpCloud<kDimension>& source, const IcpCloud<kDimension>& target,
    const typename RigidMotion<kDimension>::Pose& guess_target_T_source,
    const IcpOptions& options = {});

/// The same for bare points. With the metric kGicp their patches are computed first.
[[nodiscard]] MatchResult match_icp(std::span<const Eigen::Vector2d> source,
                                    const IcpCloud<2>& target, const Pose2& guess_target_T_source,
                                    const IcpOptions& options = {});
[[nodiscard]] MatchResult3 match_icp(std::span<const Eigen::Vector3d> source,
                                     const IcpCloud<3>& target, const Pose3& guess_target_T_source,
                                     const IcpOptions& options = {});

extern template MatchResult match_icp<2>(const IcpCloud<2>&, const IcpCloud<2>&, const Pose2&,
                                         const IcpOptions&);
extern template MatchResult3 match_icp<3>(const IcpCloud<3>&, const IcpCloud<3>&, const Pose3&,
                                          const IcpOptions&);

}  // namespace loopstone
