#pragma once

#include <Eigen/Core>
#include <optional>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/graph/solver.hpp"
#include "loopstone/registration/match_result.hpp"

namespace loopstone {

/// Closures that disagree by more standard deviations than this pull less than in proportion
/// (Huber).
inline constexpr double kClosureHuberWidth = 1.5;

/// How graphs with closures are solved.
[[nodiscard]] inline SolverOptions closure_solver() {
  return {.robust_kernel = "huber", .robust_width = kClosureHuberWidth};
}

/// Of (x, y, yaw), the same along every direction, uncorrelated.
[[nodiscard]] Eigen::Matrix3d planar_covariance(double sigma_m, double sigma_rad);

/// The motion when nothing measured it: as the last one, with little trust.
[[nodiscard]] PoseWithCovariance2 guessed_motion(const Pose2& last_motion);

/// No less uncertain than scans and wheels ever are: neighbouring points err alike, so their number
/// does not average all noise away.
[[nodiscard]] PoseWithCovariance2 with_floor(PoseWithCovariance2 motion);

/// What a match is worth beside the motion that was expected: nothing (failed, or too far from it);
/// or the match, along directions that the walls leave open as uncertain as the expectation.
[[nodiscard]] std::optional<PoseWithCovariance2> believed(const MatchResult& match,
                                                          const PoseWithCovariance2& expected);

/// From the covariance of (x, y, yaw) of from_T_to, axes of `from`, to the information of the
/// edge's error, axes of `to`.
[[nodiscard]] RelativePoseEdge edge_between(int from, int to, const PoseWithCovariance2& from_T_to,
                                            EdgeKind kind);

}  // namespace loopstone
