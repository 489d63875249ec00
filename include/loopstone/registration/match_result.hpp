#pragma once

#include <Eigen/Core>
#include <string_view>

#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// How an alignment ended. Only kConverged and kDegenerate come with a pose that the data support.
enum class MatchStatus {
  kConverged,
  kNotConverged,  ///< the iterations ran out, or the search found nothing good enough
  kTooFewPairs,   ///< too little to align; the pose is the guess
  kDegenerate,  ///< converged, but a direction is unobserved (corridor, circle): the covariance is large along it
};

[[nodiscard]] constexpr std::string_view to_string(MatchStatus status) {
  switch (status) {
    case MatchStatus::kConverged:
      return "converged";
    case MatchStatus::kNotConverged:
      return "not_converged";
    case MatchStatus::kTooFewPairs:
      return "too_few_pairs";
    case MatchStatus::kDegenerate:
      return "degenerate";
  }
  return "unknown";
}

/// Where a scan or cloud lies in the frame of another one, or of a map, and how far to trust that.
struct MatchResult {
  Pose2 target_T_source;
  /// Of (x, y, yaw) of target_T_source [m^2, m rad, rad^2].
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double rmse_m = 0.0;           ///< of the residuals of the pairs used
  double inlier_fraction = 0.0;  ///< [0, 1], share of the source points that were paired
  int pairs = 0;
  int iterations = 0;
  MatchStatus status = MatchStatus::kNotConverged;
  double score = 0.0;  ///< [0, 1], share of the source that the target explains
};

}  // namespace loopstone
