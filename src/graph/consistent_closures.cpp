#include <cstddef>
#include <vector>

#include "graph/closure_loops.hpp"
#include "loopstone/graph/outlier_rejection.hpp"

namespace loopstone {

ConsistentClosures consistent_closures(const PoseGraph& graph, const ConsistencyOptions& options) {
  check_graph(graph);
  const ClosureLoops loops(graph);
  const std::vector<ComparedClosure>& closures = loops.closures();
  std::vector<std::vector<bool>> adjacent(closures.size(),
                                          std::vector<bool>(closures.size(), false));
  for (std::size_t i = 0; i < closures.size(); ++i) {
    for (std::size_t k = i + 1; k < closures.size(); ++k) {
      if (!loops.joined(closures[i], closures[k])) continue;
      const bool agree = loops.opening(closures[i], closures[k]).chi2 <= options.consistent_chi2;
      adjacent[i][k] = agree;
      adjacent[k][i] = agree;
    }
  }
  const Clique clique = greatest_clique(adjacent, options.exact_up_to);
  ConsistentClosures result;
  result.exact = clique.exact;
  for (const int node : clique.nodes) {
    result.edges.push_back(closures[static_cast<std::size_t>(node)].edge);
  }
  return result;
}

}  // namespace loopstone
