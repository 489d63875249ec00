// Whether what comes from a file hangs together: every index lies inside what it points into. A run
// that goes on from a state where one does not would read what is not there.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "loopstone/slam/back_end.hpp"
#include "loopstone/slam/front_end.hpp"
#include "loopstone/slam/key_chain.hpp"

namespace loopstone {

namespace {

bool edges_stay_inside(const PoseGraph& graph) {
  const auto inside = [&](NodeId node) {
    return node.index >= 0 && static_cast<std::size_t>(node.index) < graph.poses.size();
  };
  // A mapper's graph has poses and edges alone.
  return graph.priors.empty() && graph.landmarks.empty() && graph.landmark_edges.empty() &&
         std::ranges::all_of(graph.fixed, inside) &&
         std::ranges::all_of(graph.edges, [&](const RelativePoseEdge& edge) {
           return inside(edge.from) && inside(edge.to);
         });
}

}  // namespace

bool only_grows(std::span<const double> travelled_m) {
  return std::ranges::all_of(travelled_m, [](double m) { return m >= 0.0 && std::isfinite(m); }) &&
         std::ranges::is_sorted(travelled_m);
}

bool KeyChain::is_sound() const {
  if (travelled_m_.size() != stretches_.size() || !only_grows(travelled_m_) ||
      !std::isfinite(length_m_ + breaks_m_))
    return false;
  const KeyScan* before = nullptr;
  for (const Stretch& stretch : stretches_) {
    if (stretch.keys.empty()) return false;
    for (const KeyScan& key : stretch.keys) {
      if (before != nullptr && key.scan <= before->scan) return false;
      before = &key;
    }
  }
  return true;
}

bool BackEnd::is_sound() const {
  const std::size_t stretches = chain_.stretch_count();
  const std::size_t submaps = loops_.submap_count();
  return outline_.poses.size() == stretches && submaps <= stretches &&
         edges_stay_inside(outline_) && edges_stay_inside(graph_) &&
         std::ranges::all_of(closures_,
                             [&](const LoopClosure& closure) {
                               return closure.from_submap.index < submaps &&
                                      closure.to_submap.index < submaps &&
                                      closure.state <= ClosureState::kRevoked &&
                                      closure.reason <= ClosureReason::kContradictsGraph;
                             }) &&
         std::ranges::all_of(thinned_, [&](std::size_t stretch) { return stretch < stretches; });
}

bool FrontEnd::submaps_lie_within(double reach_m) const {
  return std::ranges::all_of(active_, [&](const ActiveSubmap& active) {
    return active.submap.freeze().lies_within(reach_m);
  });
}

}  // namespace loopstone
