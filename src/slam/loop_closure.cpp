#include "loopstone/slam/loop_closure.hpp"

#include "slam/scan_edges.hpp"

namespace loopstone {

RelativePoseEdge edge_of(const LoopClosure& closure) {
  return edge_between(closure.from.index, closure.to.index, {closure.from_T_to, closure.covariance},
                      EdgeKind::kLoopClosure);
}

double chi2_at(const LoopClosure& closure, std::span<const Pose2> poses) {
  const auto pose = [&](NodeId node) { return poses[static_cast<std::size_t>(node.index)]; };
  return edge_chi2(edge_of(closure), pose(closure.from), pose(closure.to));
}

}  // namespace loopstone
