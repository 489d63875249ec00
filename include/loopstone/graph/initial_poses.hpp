#pragma once

#include <vector>

#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

enum class Initialisation {
  kOdometryChain,  ///< along the edges i -> i + 1; where one is missing, the spanning tree goes on
  kSpanningTree,   ///< breadth first from the first node: the fewest edges between it and any node
};

/// Poses from the measurements alone, as a start for optimize(). The first pose of each component stays where the
/// graph has it (components cannot be placed to one another). Of several edges between two nodes the first is used.
/// Cost: O(nodes + edges). Deterministic.
[[nodiscard]] std::vector<Pose2> initial_poses(const PoseGraph& graph,
                                               Initialisation initialisation);

}  // namespace loopstone
