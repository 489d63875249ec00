#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/slam/loose_parts.hpp"
#include "slam/path_chain.hpp"
#include "slam/path_posterior.hpp"

namespace loopstone {

/// What of each edge's drift nothing takes back that is recognised: all of it where fewer than two
/// recognised places lead across the edge, and of others that leave a direction open their length.
/// Without the chain's factor.
/// \param across  how many recognised places lead across each edge
[[nodiscard]] std::vector<Eigen::Matrix3d> freedom_of(std::span<const Pose2> poses,
                                                      const PathChain& chain,
                                                      std::span<const int> across);

/// How far a map may be off anywhere by what its path may have lost where nothing holds it: drawn
/// at random so many times (the same numbers each time), aligned to the map as it is, and of each
/// draw the worst place and the worst heading. To first order in all errors.
/// Cost: some hundred draws of at most some hundred steps.
[[nodiscard]] PossibleError possible_error(std::span<const Pose2> poses, const PathChain& chain,
                                           std::span<const int> across);
/// The same where surfaces hold it together.
/// \param posterior  of freedom_of() its edges
/// Cost: some hundred draws of a stretch for each dozen poses.
[[nodiscard]] PossibleError possible_error(PathPosterior& posterior);

}  // namespace loopstone
