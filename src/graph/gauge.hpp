#pragma once

#include <vector>

#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// Which poses are held where they are.
struct Gauge {
  std::vector<bool> fixed;
  int floating = 0;  ///< components that nothing but the choice of their first pose holds in place
};

[[nodiscard]] Gauge gauge_of(const PoseGraph& graph, const GraphComponents& components);

}  // namespace loopstone
