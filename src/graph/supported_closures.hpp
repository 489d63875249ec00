#pragma once

#include <vector>

#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// Which loop closures some other one backs: the loop of both and the odometry between them closes
/// to within consistent_chi2, and so narrowly that by accident none of those compared would do so,
/// but for a probability of `accident`. A false closure that agrees with nothing near it stays out
/// of the rounds of graduated non-convexity, where it would make the factor dense; a lone true one
/// is taken back by settle_closures.
///
/// By edge; false for what is no loop closure. Cost: O(closures * those that odometry leads to with
/// little error). An accident is a pose drawn uniformly from the bounding box of the odometry, as
/// in the a-contrario test of Desolneux, Moisan and Morel 2000, "Meaningful alignments".
[[nodiscard]] std::vector<bool> supported_closures(const PoseGraph& graph, double consistent_chi2,
                                                   double accident = 0.05);

}  // namespace loopstone
