#include "loopstone/graph/solver.hpp"

#include <utility>

#include "graph/block_cholesky.hpp"
#include "graph/descent.hpp"
#include "graph/gauge.hpp"
#include "graph/normal_equations.hpp"

namespace loopstone {

SolveResult optimize(const PoseGraph& graph, const SolverOptions& options,
                     const StopQuestion& stop) {
  check_graph(graph);
  const RobustPolicy policy{options.robust_kernel, options.robust_width, options.robust_everywhere};
  const DescentOptions descent{options.method, options.max_iterations, options.relative_tolerance};
  const GraphComponents components = connected_components(graph);
  const Gauge gauge = gauge_of(graph, components);
  NormalEquations equations(graph, gauge.fixed, policy);
  BlockCholesky cholesky(equations.hessian());
  GraphState state{graph.poses, graph.landmarks};
  const DescentResult found = descend(equations, cholesky, descent, state, stop);

  SolveResult result;
  result.cost_initial = found.initial.plain;
  result.robust_cost_initial = found.initial.robust;
  result.cost = found.final.plain;
  result.robust_cost = found.final.robust;
  result.iterations = found.iterations;
  result.components = components.count;
  result.status = found.status;
  if (components.count > 1 && gauge.floating > 0) result.status = SolveStatus::kDisconnected;
  GraphWeights weights = equations.weights(state);
  result.edge_weights = std::move(weights.edges);
  result.prior_weights = std::move(weights.priors);
  result.landmark_weights = std::move(weights.landmark_edges);
  result.poses = std::move(state.poses);
  result.landmarks = std::move(state.landmarks);
  return result;
}

}  // namespace loopstone
