#include "loopstone/slam/loop_closure.hpp"

#include "slam/scan_edges.hpp"

namespace loopstone {

std::string_view to_string(ClosureState state) {
  switch (state) {
    case ClosureState::kWaiting:
      return "waiting";
    case ClosureState::kStanding:
      return "standing";
    case ClosureState::kRejected:
      return "rejected";
    case ClosureState::kRevoked:
      return "revoked";
  }
  return "unknown";
}

std::string_view to_string(ClosureReason reason) {
  switch (reason) {
    case ClosureReason::kNone:
      return "";
    case ClosureReason::kTooFewPairs:
      return "refinement found too few pairs";
    case ClosureReason::kAmbiguousPose:
      return "ambiguous: another pose scores nearly as well";
    case ClosureReason::kAmbiguousPlace:
      return "ambiguous: another place matches as well";
    case ClosureReason::kTooLittleOverlap:
      return "too little overlap";
    case ClosureReason::kSurfacesDisagree:
      return "surfaces disagree";
    case ClosureReason::kWaitsForSecond:
      return "waits for a second closure that asks for the same";
    case ClosureReason::kNoSecond:
      return "no second closure asks for the same";
    case ClosureReason::kContradictsGraph:
      return "revoked: contradicts the rest of the graph";
  }
  return "unknown";
}

RelativePoseEdge edge_of(const LoopClosure& closure) {
  return edge_between(closure.from.index, closure.to.index, {closure.from_T_to, closure.covariance},
                      EdgeKind::kLoopClosure);
}

double chi2_at(const LoopClosure& closure, std::span<const Pose2> poses) {
  const auto pose = [&](NodeId node) { return poses[static_cast<std::size_t>(node.index)]; };
  return edge_chi2(edge_of(closure), pose(closure.from), pose(closure.to));
}

}  // namespace loopstone
