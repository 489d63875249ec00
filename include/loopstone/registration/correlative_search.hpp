#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/grid/max_pyramid.hpp"

namespace loopstone {

/// The meaning of a cell that points are scored against: kContradiction where the place was seen to
/// be free, kUnknown where nobody looked, kSurface on a surface, values between near one.
inline constexpr std::uint8_t kContradiction = 0;
inline constexpr std::uint8_t kUnknown = 100;
inline constexpr std::uint8_t kSurface = 200;

/// The poses to search: those within half_xy_m (a square) and half_yaw_rad of the centre.
struct SearchWindow {
  Pose2 centre;  ///< target_T_source
  double half_xy_m = 1.0;
  double half_yaw_rad = 0.35;
};

/// Poses that a search leaves out: near `pose` in both translation and heading.
struct ExcludedPoses {
  Pose2 pose;
  double radius_m = 0.5;
  double half_yaw_rad = 0.17;
};

struct SearchResult {
  bool found =
      /// false: no pose in the window scores above the threshold; that is proven, not given up
      false;
  Pose2 target_T_source;
  double score =
      0.0;  ///< [-1, 1]: +1 all points on surfaces, 0 all in unknown, -1 all in free space
  std::int64_t evaluations = 0;  ///< poses and blocks of poses that were scored
};

/// The best pose of points on a grid of surfaces, over the whole window at the grid's resolution:
/// branch and bound, exact.
///
/// \param source     points, source frame [m]; about 100 to 500 are enough
/// \param target     pyramid of cells with the meaning above, in the target frame
/// \param min_score  poses below are of no interest; the higher, the faster
/// The heading step moves the farthest point (from the points' centre) by one cell.
/// Ties go to the pose that comes first (heading, then row, then column).
/// Cost: grows with the window's volume and with how many places look alike. In a building at 5 cm
/// with 300 points: 1 ms for 0.5 m and 20 deg, 9 ms for 4 m and 90 deg.
/// Deterministic. Thread-safe.
/// Source: Olson 2009, "Real-time correlative scan matching"; Hess et al. 2016, algorithm 3.
[[nodiscard]] SearchResult search_branch_and_bound(
    std::span<const Eigen::Vector2d> source, const MaxPyramid& target, const SearchWindow& window,
    double min_score, const std::optional<ExcludedPoses>& excluded = {});

}  // namespace loopstone
