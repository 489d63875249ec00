#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "localization/landmark_group.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// Two groups that are one landmark.
struct GroupPair {
  std::size_t newer = 0;
  std::size_t older = 0;
  bool moves_map = false;  ///< they are farther apart than sightings alone would have it
};

/// Which of the newer groups are landmarks that are among the older ones.
///
/// The newer ones are a constellation, seen as if all at once from a pose among them; how well that
/// pose is known against the older ones nearby is what the graph says (joint_covariances). They are
/// paired jointly; a pair counts when the most probable pairing is kLandmarkMapping.odds times as
/// probable as the best one without it: where racks repeat and drift is wide, none does. What was
/// ever seen beside another is not that one.
///
/// \param graph   of poses and landmarks, solved; a path of edges i -> i + 1 at least
/// \param groups  all of them; `newer` and `older` are indices
/// Without names only. Cost: two factorisations of the graph, and as many associations as pairs.
[[nodiscard]] std::vector<GroupPair> recognise(const PoseGraph& graph,
                                               std::span<const LandmarkGroup> groups,
                                               std::span<const std::size_t> newer,
                                               std::span<const std::size_t> older,
                                               const LandmarkScene& scene);

}  // namespace loopstone
