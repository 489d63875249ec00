#pragma once

#include <cstdint>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/odometry/trajectory.hpp"

namespace loopstone {

struct ErrorStatistics {
  double mean = 0.0;
  double std = 0.0;  ///< with n - 1
  double rmse = 0.0;
  double median = 0.0;
  double max = 0.0;
};

/// Statistics of errors; all zero when there are none, std zero when there is one.
[[nodiscard]] ErrorStatistics statistics_of(std::vector<double> errors);

enum class Alignment { kNone, kSe2 };

constexpr auto words_of(Alignment /*any*/) {
  using enum Alignment;
  return std::array{Word{kSe2, "se2"}, Word{kNone, "none"}};
}

/// Errors of one pose, or of the motion of one pair, after the other.
struct PoseErrors {
  std::vector<Stamp> stamps{};  ///< of the reference; of a pair, of its first pose
  std::vector<double> translation_m{};
  std::vector<double> rotation_rad{};  ///< not negative
};

/// Absolute trajectory error.
struct AbsoluteError {
  ErrorStatistics translation_m;
  ErrorStatistics rotation_rad;    ///< of |wrapped heading difference|
  Pose2 reference_T_estimate;      ///< the alignment that was applied
  std::int64_t poses = 0;          ///< that were compared
  std::int64_t poses_missing = 0;  ///< reference poses outside the estimate's time
  PoseErrors by_pose{};            ///< of each that was compared
};

/// The rigid motion that brings the points of `estimate` nearest to those of `reference`, pair by
/// pair, in the sense of least squares: reference_T_estimate. Where the points do not tell the
/// rotation (all in one place), the headings do.
/// Source: Umeyama 1991, without scale, which in the plane is an atan2.
/// Both must have the same size.
[[nodiscard]] Pose2 align_trajectories(const std::vector<Pose2>& estimate,
                                       const std::vector<Pose2>& reference);

/// How far the estimate is from the reference at the reference's stamps (the estimate interpolated
/// along arcs), after the alignment. Reference stamps outside the estimate's time are counted as
/// missing, never clamped.
/// Source: Sturm et al. 2012, "A benchmark for the evaluation of RGB-D SLAM systems", section IV.B.
[[nodiscard]] AbsoluteError absolute_error(const Trajectory& estimate, const Trajectory& reference,
                                           Alignment alignment);

/// What separates the two poses of a pair.
enum class Spacing { kFrames, kMetres, kSeconds };

/// Relative pose error.
struct RelativeError {
  ErrorStatistics translation_m;
  ErrorStatistics rotation_rad;
  std::int64_t pairs = 0;
  PoseErrors by_pair{};  ///< of each of them
};

/// How much the motion over a stretch differs: of (reference_i^-1 reference_j)^-1 (estimate_i^-1
/// estimate_j), for every reference pose i and the first j that is `delta` frames, metres of
/// reference path or seconds later. Independent of any alignment. Source: Sturm et al. 2012,
/// section IV.A.
[[nodiscard]] RelativeError relative_error(const Trajectory& estimate, const Trajectory& reference,
                                           double delta, Spacing spacing);

}  // namespace loopstone
