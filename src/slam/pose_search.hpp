#pragma once

#include <Eigen/Core>
#include <span>

#include "loopstone/grid/max_pyramid.hpp"
#include "loopstone/registration/correlative_search.hpp"

namespace loopstone {

/// The best pose of a robot's points on a map within a window of the robot's own positions and headings. The correlative
/// search underneath turns points about their centre; in slices of the heading range both are the same.
/// Cost: that of search_branch_and_bound over the window, a little more. Deterministic.
[[nodiscard]] SearchResult search_about_robot(std::span<const Eigen::Vector2d> points,
                                              const MaxPyramid& target, const SearchWindow& window,
                                              double min_score);

/// What the search would say of one pose: +1 all points on surfaces, -1 all where there is free space.
[[nodiscard]] double agreement_at(std::span<const Eigen::Vector2d> points, const MaxPyramid& target,
                                  const Pose2& target_T_robot);

}  // namespace loopstone
