#pragma once

#include <vector>

#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// What is known to one standard deviation of this, by the path or by a loop closure, is tied.
/// Walls that lie beside one another are the same then; where the heading is open, they may be
/// others.
struct TieBounds {
  double near_m;
  double near_rad;
};

/// Parts of a path that its breaks separate and nothing ties to one another so well that what one
/// of them saw can be told from what stands beside it. Of each pose of the graph the number of its
/// part; the first one's is 0.
/// \param broken  of each pose, whether the laser did not hold the path from the one before; empty:
///                nowhere
[[nodiscard]] std::vector<int> tied_parts(const PoseGraph& graph, const std::vector<bool>& broken,
                                          const TieBounds& bounds);

/// Breaks that the path does not tie by itself.
[[nodiscard]] std::vector<bool> untied_breaks(const PoseGraph& graph, std::vector<bool> broken,
                                              const TieBounds& bounds);

}  // namespace loopstone
