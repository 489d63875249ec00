#pragma once

#include <functional>
#include <vector>

#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/slam/loop_closure.hpp"

namespace loopstone {

/// Solves a graph with the closures that stand. The worst that can't be reconciled with the rest is
/// revoked; then what is left is solved again.
/// \param graph       of the closures' nodes, without them; its poses are the start, and the result
/// \param may_revoke  whether a closure may go; empty: any
/// \param revoked     told of each that goes; may be empty
void solve_closures(PoseGraph& graph, std::vector<LoopClosure>& closures,
                    const std::function<bool(const LoopClosure&)>& may_revoke,
                    const std::function<void(const LoopClosure&)>& revoked);

}  // namespace loopstone
