#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/registration/cloud_search.hpp"

namespace loopstone {

/// \param points   finite, at least one
/// \param upright  turns about the z axis alone; in the plane of no meaning
template <int kDimension>
[[nodiscard]] PrincipalFrame<kDimension> principal_frame(
    std::span<const Eigen::Matrix<double, kDimension, 1>> points, bool upright);

/// The points on the frame's axes, about its centre.
template <int kDimension>
[[nodiscard]] std::vector<Eigen::Matrix<float, kDimension, 1>> in_frame(
    std::span<const Eigen::Matrix<double, kDimension, 1>> points,
    const PrincipalFrame<kDimension>& frame);

/// Which of the points stand for all: of each cell of a grid that holds any, the one nearest to
/// their mean. The cells are of a size that leaves about `count`; the grid is laid through the
/// origin. Does not depend on the order of points, but for rounding.
/// Cost: O(points).
template <int kDimension>
[[nodiscard]] std::vector<std::size_t> spread_sample(
    std::span<const Eigen::Matrix<float, kDimension, 1>> points, std::size_t count);

}  // namespace loopstone
