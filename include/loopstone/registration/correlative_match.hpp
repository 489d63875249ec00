#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "loopstone/registration/correlative_search.hpp"
#include "loopstone/registration/match_result.hpp"

namespace loopstone {

struct CorrelativeTargetOptions {
  double cell_m = 0.05;  ///< of the grid that is searched
  double blur_m = 0.05;  ///< standard deviation of the bump around each point
};

/// A reference scan or cloud as a grid to search on: kSurface at its points, fading to kUnknown
/// around them.
///
/// \param points       target frame [m]; not empty
/// \param half_xy_m    of the windows that will be searched: a wider one deserves more levels
/// Cost: about 0.1 to 0.5 ms for a scan in a building.
[[nodiscard]] MaxPyramid make_correlative_target(std::span<const Eigen::Vector2d> points,
                                                 double half_xy_m,
                                                 const CorrelativeTargetOptions& options = {});

struct CorrelativeMatchOptions {
  double min_score = 0.3;  ///< poses that score less are no match
  double evidence = 0.5;   ///< log likelihood that a point gains from nothing to a surface
  double max_ambiguity =
      0.95;  ///< a second peak with more than this share of the best score is as good
  double distinct_m = 0.5;  ///< peaks that differ by less than this and distinct_rad are one
  double distinct_rad = 0.17;
};

/// A match and how well the next best place fits.
struct CorrelativeMatch {
  MatchResult match{};
  double second_score = 0.0;           ///< of the best peak elsewhere in the window; 0: none
  std::optional<Pose2> second_pose{};  ///< where it is, when there is one above half the best score
};

/// The best pose of a whole window, refined between the steps of the lattice, with the covariance
/// of the score volume.
///
/// With sums S(x) of the cells that the points fall in at pose x, likelihood p(x) = exp(evidence
/// (S(x) - S_best)):
///
///   covariance = sum p x x^T / sum p - (sum p x)(sum p x)^T / (sum p)^2 + that within one step of
///   the lattice,
///
/// over the poses around the best one whose likelihood counts. Within a step it is the inverse of
/// the curvature of S, bounded by the step itself.
///
/// \param source  points in the source frame [m]
/// \param target  cells with the meaning of correlative_search.hpp
/// \return status kNotConverged: no pose in the window scores min_score, the pose is the window's
///         centre. kDegenerate: the peak is a ridge (a corridor) or runs out of the window, or a
///         second one is as good; the covariance covers them. score: of the pose on the lattice, at
///         least 0; iterations: poses and blocks that were scored; pairs: points on or near a
///         surface; rmse_m is 0, a score has no residuals.
/// Cost: of search_branch_and_bound, twice, and some 0.1 ms; a ridge of metres takes more.
/// Deterministic. Thread-safe.
/// Source: Olson 2009, "Real-time correlative scan matching", sections III and IV.B.
[[nodiscard]] CorrelativeMatch match_correlative(std::span<const Eigen::Vector2d> source,
                                                 const MaxPyramid& target,
                                                 const SearchWindow& window,
                                                 const CorrelativeMatchOptions& options = {});

}  // namespace loopstone
