#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "loopstone/grid/max_pyramid.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "loopstone/registration/grid_matcher.hpp"

namespace loopstone {

/// What the search for a pose decides by.
struct PoseSearchNumbers {
  double min_score = 0.25;
  double slice_rad = 0.15;
  int points = 200;
};
inline constexpr PoseSearchNumbers kPoseSearch{};

template <typename Visitor>
void visit_numbers(const PoseSearchNumbers& n, Visitor&& visit) {
  visit("min_score", n.min_score,
        "chosen: of a search; a scan of which not even a quarter more lies on surfaces than in "
        "free space contradicts the map");
  visit("slice_rad", n.slice_rad,
        "chosen: half of the headings searched at once, so that turning about the points' centre "
        "and about the robot are nearly the same");
  visit("points", n.points, "chosen: of a scan, evenly spread; a search costs in proportion");
}

/// The best pose of a robot's points on a map within a window of the robot's own positions and
/// headings. The correlative search underneath turns points about their centre; in slices of the
/// heading range both are the same.
/// Cost: that of search_branch_and_bound over the window, a little more. Deterministic.
[[nodiscard]] SearchResult search_about_robot(std::span<const Eigen::Vector2d> points,
                                              const MaxPyramid& target, const SearchWindow& window,
                                              double min_score);

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
