#pragma once

#include <Eigen/Core>
#include <vector>

#include "loopstone/base/words.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

enum class Initialisation {
  kAsGiven,        ///< the graph's own poses
  kOdometryChain,  ///< along the edges i -> i + 1; where one is missing, the spanning tree goes on
  kSpanningTree,   ///< breadth first from the first node: the fewest edges between it and any node
  kChordal,        ///< all edges at once: headings by a linear relaxation, then positions
};

constexpr auto words_of(Initialisation /*any*/) {
  using enum Initialisation;
  return std::array{Word{kAsGiven, "file"}, Word{kOdometryChain, "odometry"},
                    Word{kSpanningTree, "spanning_tree"}, Word{kChordal, "chordal"}};
}

/// Poses from the measurements alone, as a start for optimize(). Held poses stay where the graph
/// has them; a component without one begins at a prior, or else its first pose stays (components
/// cannot be placed to one another). Of several edges between two nodes chain and tree use the
/// first; priors beyond the first of a component count for kChordal only.
/// Cost: O(nodes + edges); kChordal two sparse linear solves. Deterministic.
/// Source of kChordal: Carlone et al. 2015, "Initialization techniques for 3D SLAM", section III-C.
[[nodiscard]] std::vector<Pose2> initial_poses(const PoseGraph& graph,
                                               Initialisation initialisation);

/// Each landmark where the poses that see it see it, on average; one that nobody sees stays where
/// it is.
[[nodiscard]] std::vector<Eigen::Vector2d> initial_landmarks(const PoseGraph& graph);

/// One of several starts, and the sum of e^T information e that it has.
struct GraphStart {
  Initialisation initialisation = Initialisation::kAsGiven;
  std::vector<Pose2> poses{};
  std::vector<Eigen::Vector2d> landmarks{};
  double cost = 0.0;
};

/// A start of one kind. Landmarks follow from the poses, except with kAsGiven.
[[nodiscard]] GraphStart make_start(const PoseGraph& graph, Initialisation initialisation);

/// The cheapest of kChordal, kSpanningTree and kOdometryChain, and with `poses_given` of the
/// graph's own poses.
[[nodiscard]] GraphStart best_start(const PoseGraph& graph, bool poses_given);

}  // namespace loopstone
