#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "loopstone/grid/max_pyramid.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "loopstone/registration/grid_matcher.hpp"

namespace loopstone {

/// The best pose of a robot's points on a map within a window of the robot's own positions and
/// headings. The correlative search underneath turns points about their centre; in slices of the
/// heading range both are the same.
/// Cost: that of search_branch_and_bound over the window, a little more. Deterministic.
[[nodiscard]] SearchResult search_about_robot(std::span<const Eigen::Vector2d> points,
                                              const MaxPyramid& target, const SearchWindow& window,
                                              double min_score);

/// Below this score of a search a scan contradicts the map.
inline constexpr double kSearchMinScore = 0.25;

/// Some hundred positions of a scan, evenly spread, to search with.
[[nodiscard]] std::vector<Eigen::Vector2d> search_points(std::span<const SurfacePoint> surfaces);

/// Squared Mahalanobis distance of a match from a prior: chi-square of three degrees of freedom.
[[nodiscard]] double chi2_from(const PosePrior2& prior, const MatchResult& match);

/// Variance of a position along its worst direction [m^2]: the larger eigenvalue of the upper left
/// block.
[[nodiscard]] double position_variance_m2(const Eigen::Matrix3d& covariance);

/// What the search would say of one pose: +1 all points on surfaces, -1 all where there is free
/// space.
[[nodiscard]] double agreement_at(std::span<const Eigen::Vector2d> points, const MaxPyramid& target,
                                  const Pose2& target_T_robot);

}  // namespace loopstone
