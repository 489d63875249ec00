#pragma once

#include <Eigen/Core>
#include <optional>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/graph/solver.hpp"
#include "loopstone/registration/match_result.hpp"

namespace loopstone {

/// What edges between scans are made and weighed by.
struct ScanEdgesNumbers {
  double gate_m = 0.5;
  double gate_rad = 0.35;
  double floor_m = 0.005;
  double floor_rad = 0.002;
  double guessed_m = 0.3;
  double guessed_rad = 0.2;
  double huber_width = 1.5;
};
inline constexpr ScanEdgesNumbers kScanEdges{};

template <typename Visitor>
void visit_numbers(const ScanEdgesNumbers& n, Visitor&& visit) {
  visit("gate_m", n.gate_m,
        "chosen: a match farther from the expected motion is not believed: scans of a stream "
        "follow one another more closely");
  visit("gate_rad", n.gate_rad, "chosen: nor turned by so much, 20 degrees");
  visit(
      "floor_m", n.floor_m,
      "chosen: no match is more certain: neighbouring points err alike, half a centimetre is left");
  visit("floor_rad", n.floor_rad, "chosen: likewise, a tenth of a degree");
  visit("guessed_m", n.guessed_m,
        "chosen: of a motion that nothing measured; as coast_most_m of the prediction");
  visit("guessed_rad", n.guessed_rad, "chosen: likewise, some ten degrees");
  visit("huber_width", n.huber_width,
        "chosen: closures that disagree by more standard deviations pull less than in proportion "
        "(Huber): between 1.345, where 95 % of the efficiency is kept, and 2");
}

/// Closures that disagree by more standard deviations than this pull less than in proportion
/// (Huber).
inline constexpr double kClosureHuberWidth = kScanEdges.huber_width;

/// How graphs with closures are solved.
[[nodiscard]] inline SolverOptions closure_solver() {
  return {.robust_kernel = RobustKernel::kHuber, .robust_width = kClosureHuberWidth};
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
