#pragma once

#include <Eigen/Core>
#include <limits>

#include "loopstone/base/words.hpp"
#include "loopstone/geometry/rigid_motion.hpp"

namespace loopstone {

/// How an alignment ended. Only kConverged and kDegenerate come with a pose that the data support.
enum class MatchStatus {
  kConverged,
  kNotConverged,  ///< the iterations ran out, or the search found nothing good enough
  kTooFewPairs,   ///< too little to align; the pose is the guess, of unknown covariance
  /// converged, but a direction is unobserved (corridor, circle): the covariance is large along it
  kDegenerate,
};

constexpr auto words_of(MatchStatus /*any*/) {
  using enum MatchStatus;
  return std::array{Word{kConverged, "converged"}, Word{kNotConverged, "not_converged"},
                    Word{kTooFewPairs, "too_few_pairs"}, Word{kDegenerate, "degenerate"}};
}

/// Whether the data support the pose.
[[nodiscard]] constexpr bool has_supported_pose(MatchStatus status) {
  return status == MatchStatus::kConverged || status == MatchStatus::kDegenerate;
}

/// Where a scan or cloud lies in the frame of another one, or of a map, and how far to trust that.
/// Every matcher, in the plane and in space, answers with this, so matchers can be swapped and
/// chained.
template <int kDimension>
struct BasicMatchResult {
  using Motion = RigidMotion<kDimension>;

  typename Motion::Pose target_T_source{};
  /// Of the small motion of target_T_source: (x, y, yaw), or (x, y, z, rotation vector), on the
  /// target's axes, turns about the source's origin [m^2, m rad, rad^2]. Infinite variances where
  /// no pose was found: with kTooFewPairs, and when a search found nothing.
  Eigen::Matrix<double, Motion::kDof, Motion::kDof> covariance = unknown_covariance();
  double rmse_m = 0.0;           ///< of the residuals of the pairs used
  double inlier_fraction = 0.0;  ///< [0, 1], share of the source points that were paired
  int pairs = 0;                 ///< the inliers: source points that were paired
  int iterations = 0;
  MatchStatus status = MatchStatus::kNotConverged;
  double score = 0.0;  ///< [0, 1], share of the source that the target explains

  /// What is known of a pose of which nothing is: infinite variances.
  [[nodiscard]] static Eigen::Matrix<double, Motion::kDof, Motion::kDof> unknown_covariance() {
    return Motion::Tangent::Constant(std::numeric_limits<double>::infinity()).asDiagonal();
  }
};

using MatchResult = BasicMatchResult<2>;
using MatchResult3 = BasicMatchResult<3>;

}  // namespace loopstone
