#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/registration/match_result.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/sensor/scan_points.hpp"

namespace loopstone {

/// A scan made ready for matching: its surfaces, and which of them lies in which direction from the
/// lidar.
struct ScanView {
  std::vector<SurfacePoint> surfaces{};  ///< frame of the robot at the scan's stamp
  Eigen::Vector2d lidar{0.0, 0.0};       ///< where the lidar stood, same frame [m]
  double beam_spacing_rad = 0.0;         ///< between neighbouring beams, > 0
  double surface_spacing_m = 0.05;       ///< at least this far apart are the surfaces
  double support_m = 0.12;  ///< a surface is fitted to the returns up to this far on both sides
  std::vector<std::int16_t> by_direction{};  ///< index into surfaces, -1: nothing that way
};

/// \param velocity  of the robot in its own frame [m/s, m/s, rad/s]; undoes the motion during the
///                  sweep
/// Cost: O(beams).
[[nodiscard]] ScanView view_scan(const LaserScan& scan, const Pose2& robot_T_lidar,
                                 const Tangent2& velocity, BeamTable& beams,
                                 const SurfaceOptions& options = {});

struct ScanMatchOptions {
  double search_half_xy_m = 1.0;
  double search_half_yaw_rad = 0.87;
  int candidates = 10;
  int max_iterations = 30;
  double kernel_width_m = 0.03;
};

template <typename Visitor>
void visit_options(ScanMatchOptions& options, Visitor&& visit) {
  visit("search_half_xy_m", options.search_half_xy_m, Range{0.0, 3.0},
        "how far the guess may be off in x and y; with search_half_yaw_rad 0: no search");
  visit("search_half_yaw_rad", options.search_half_yaw_rad, Range{0.0, 3.15},
        "how far the guess's heading may be off");
  visit("candidates", options.candidates, Range{1, 50}, "poses of the search that are looked into");
  visit("max_iterations", options.max_iterations, Range{1, 200}, "Gauss-Newton steps");
  visit("kernel_width_m", options.kernel_width_m, Range{0.001, 1.0},
        "distances beyond this count less and less (Cauchy kernel)");
}

/// Where one scan was taken, seen from another one. The guess is pulled in and judged from both
/// sides, by what each scan explains of the other and what it saw through; when that leaves a
/// doubt, every pose of a coarse lattice around the guess is scored, and the best distinct ones are
/// pulled in and judged alike. The best of all is refined by Gauss-Newton on point-to-line
/// distances with a Cauchy kernel. A point's partner is looked up by its direction from the
/// target's lidar, so nothing is searched and no map is built.
///
/// \param guess_target_T_source  wrong by up to the search window of the options
/// \return target_T_source of the robot frames, with a covariance from the noise of the ranges that
///         the residuals show. score = share of the source that the target explains. kTooFewPairs:
///         fewer than 8 pairs, the pose is the guess.
///         kDegenerate: a direction is unobserved (a corridor's axis, a circle's heading); along it
///                      the pose is the guess and
///         the covariance is large. kNotConverged: the scans explain too little of each other to be
///         of the same place, less than 80 % of what they could see or 45 % of the whole.
/// Cost: O(headings * shifts + iterations * surfaces); docs/benchmarks.md. Deterministic.
/// Thread-safe.
/// Source: Olson 2009 for the search; Censi 2008 for point-to-line; Blais and Levine 1995 for
/// projection; Zhang, Kaess and Singh 2016 for degenerate directions.
[[nodiscard]] MatchResult match_scans(const ScanView& source, const ScanView& target,
                                      const Pose2& guess_target_T_source,
                                      const ScanMatchOptions& options = {});

}  // namespace loopstone
