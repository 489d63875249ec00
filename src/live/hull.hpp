#pragma once

#include <Eigen/Core>
#include <vector>

namespace loopstone {

/// The convex hull, counter-clockwise from the leftmost point; fewer than 3 points when there are
/// no more. Source: Andrew 1979, "Another efficient algorithm for convex hulls in two dimensions".
[[nodiscard]] std::vector<Eigen::Vector2f> convex_hull(std::vector<Eigen::Vector2f> points);

}  // namespace loopstone
