#include "slam/closure_solution.hpp"

#include "loopstone/graph/solver.hpp"
#include "loopstone/slam/back_end.hpp"
#include "slam/scan_edges.hpp"

namespace loopstone {

void solve_closures(PoseGraph& graph, std::vector<LoopClosure>& closures,
                    const std::function<bool(const LoopClosure&)>& may_revoke,
                    const std::function<void(const LoopClosure&)>& revoked) {
  while (true) {
    PoseGraph whole = graph;
    for (const auto& closure : closures) {
      if (closure.stands()) whole.edges.push_back(edge_of(closure));
    }
    graph.poses = optimize(whole, closure_solver()).poses;
    LoopClosure* worst = nullptr;
    for (auto& closure : closures) {
      if (!closure.stands()) continue;
      closure.chi2 = chi2_at(closure, graph.poses);
      if (*closure.chi2 > kBackEnd.revoke_chi2 && (!may_revoke || may_revoke(closure)) &&
          (worst == nullptr || closure.chi2 > worst->chi2))
        worst = &closure;
    }
    if (worst == nullptr) return;
    worst->state = ClosureState::kRevoked;
    worst->reason = ClosureReason::kContradictsGraph;
    if (revoked) revoked(*worst);
  }
}

}  // namespace loopstone
