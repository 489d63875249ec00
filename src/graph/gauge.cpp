#include "graph/gauge.hpp"

#include <cstddef>

namespace loopstone {

Gauge gauge_of(const PoseGraph& graph, const GraphComponents& components) {
  Gauge gauge;
  gauge.fixed.assign(graph.poses.size(), false);
  std::vector<bool> held(static_cast<std::size_t>(components.count), false);
  const auto component_of = [&components](std::size_t node) {
    return static_cast<std::size_t>(components.of_node[node]);
  };
  for (const NodeId node : graph.fixed) {
    const auto index = static_cast<std::size_t>(node.index);
    gauge.fixed[index] = true;
    held[component_of(index)] = true;
  }
  for (const PosePrior& prior : graph.priors) {
    held[component_of(static_cast<std::size_t>(prior.node.index))] = true;
  }
  for (std::size_t node = 0; node < graph.poses.size(); ++node) {
    if (held[component_of(node)]) continue;
    held[component_of(node)] = true;
    gauge.fixed[node] = true;
    ++gauge.floating;
  }
  return gauge;
}

}  // namespace loopstone
