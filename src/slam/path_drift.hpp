#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <span>

#include "loopstone/slam/key_scan.hpp"
#include "loopstone/slam/path_break.hpp"
#include "loopstone/slam/step_drift.hpp"
#include "loopstone/slam/tracked_pose.hpp"

namespace loopstone {

/// What adds up along a path that was matched scan by scan.
struct PathDriftNumbers {
  double rest_m = 0.0005;
  double travel_share = 0.003;
  double rest_rad = 0.0002;
  double turn_share = 0.003;
  double floor_m = 0.004;
  double floor_rad = 0.0012;
  double prior = 0.01;
  double memory = 8.0;
  double open_share = 1.0;
  double walk_m = 0.005;
  double thinned_share = 0.03;
};
inline constexpr PathDriftNumbers kPathDrift{};

template <typename Visitor>
void visit_numbers(const PathDriftNumbers& n, Visitor&& visit) {
  visit("rest_m", n.rest_m,
        "measured by bench/covariances.py: what adds up from key scan to key scan however good the "
        "match");
  visit("travel_share", n.travel_share,
        "measured by bench/covariances.py: the same, of the distance between them");
  visit("rest_rad", n.rest_rad, "measured by bench/covariances.py: as rest_m, of the heading");
  visit("turn_share", n.turn_share, "measured by bench/covariances.py: the same, of the turn");
  visit("floor_m", n.floor_m,
        "measured by bench/covariances.py: so much of a match's uncertainty is noise of its own "
        "and never adds up");
  visit("floor_rad", n.floor_rad, "measured by bench/covariances.py: as floor_m, of the heading");
  visit("prior", n.prior,
        "derived: wheel_rest_m of the motion predictor: a match this uncertain (m, rad) rests on "
        "odometry alone, and its errors add up in full");
  visit("memory", n.memory,
        "measured by bench/covariances.py: matches that hold well share their submap's error over "
        "so many more key scans");
  visit("open_share", n.open_share,
        "chosen: a direction of which the laser knows no more than a resting odometer is open: "
        "some four "
        "points face along it");
  visit(
      "walk_m", n.walk_m,
      "measured by bench/covariances.py: what odometry, once its scale is known, loses there in a "
      "metre, growing as the square root of the way");
  visit("thinned_share", n.thinned_share,
        "measured by bench/covariances.py: of the noise of edges whose key scans were thinned out, "
        "so much adds up");
}

/// How far the path may drift from one key scan to the next. Most of a match's uncertainty is noise
/// that the next match to the same submap takes back; what is left adds up along the path. Where
/// the scan leaves a direction open, that is all it was granted, or how far it is off what odometry
/// says, and odometry's own errors.
/// \param told  by odometry, with its scale; nothing where that is not known
[[nodiscard]] StepDrift drift_between(const KeyScan& previous, const KeyScan& next,
                                      const std::optional<Pose2>& told);

/// What odometry told of a path.
struct ToldPath {
  const std::deque<TrackedPose>& track;  ///< of all scans
  double scale = 0.0;                    ///< odometry's way / the real one; 0: not known
  std::span<const PathBreak> breaks{};   ///< in order; while they lasted it may have been silent
};

/// The motion from one key scan to another as odometry tells it; nothing across a break.
[[nodiscard]] std::optional<Pose2> told_between(const KeyScan& previous, const KeyScan& next,
                                                const ToldPath& path);

/// Whether a match left a translation to odometry.
[[nodiscard]] bool rests_on_odometry(const Eigen::Matrix3d& covariance);

/// By how much the path is too long in sum where the laser left a direction open, if odometry's way
/// is too long by a factor all along: what was driven before the factor was known [m].
[[nodiscard]] double open_travel_error_m(std::span<const KeyScan> keys, const ToldPath& path);

}  // namespace loopstone
