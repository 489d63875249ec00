#pragma once

#include <span>

#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// Weighted mean of poses, headings averaged on the circle, and the covariance about it. Weights
/// sum to one.
[[nodiscard]] PoseWithCovariance2 weighted_moments(std::span<const Pose2> poses,
                                                   std::span<const double> weights);

}  // namespace loopstone
