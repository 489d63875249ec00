#pragma once

#include <span>

#include "loopstone/slam/loose_parts.hpp"
#include "slam/path_chain.hpp"

namespace loopstone {

/// How far a map may be off anywhere by what its path may have lost where nothing holds it: drawn
/// at random so many times (the same numbers each time), aligned to the map as it is, and of each
/// draw the worst place and the worst heading. To first order in all errors.
///
/// Free are edges that fewer than two recognised places lead across, and of all others that leave a
/// direction open their length.
/// \param across  how many recognised places lead across each edge
/// Cost: some hundred draws of at most some hundred steps.
[[nodiscard]] PossibleError possible_error(const PoseGraph& graph, const PathChain& chain,
                                           std::span<const int> across);

}  // namespace loopstone
