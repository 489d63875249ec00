#pragma once

#include <vector>

#include "graph/normal_equations.hpp"
#include "loopstone/base/stop_question.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// Goes on from a choice of loop closures (weights 1 and 0) until each accepted one agrees with the
/// others and no rejected one does, a bound on the rounds is met, or it is stopped. State: the
/// solution with the accepted ones.
void settle_closures(const PoseGraph& graph, const std::vector<bool>& fixed, double inlier_chi2,
                     std::vector<double>& weights, GraphState& state,
                     const StopQuestion& stop = {});

}  // namespace loopstone
