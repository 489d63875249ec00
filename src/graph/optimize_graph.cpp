#include "loopstone/graph/optimize_graph.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <utility>
#include <vector>

namespace loopstone {

namespace {

/// Adds the wall time and the CPU time of its life.
class PartTimer {
 public:
  PartTimer(double& wall_s, double& cpu_s) : wall_s_(wall_s), cpu_s_(cpu_s) {}
  ~PartTimer() {
    wall_s_ += std::chrono::duration<double>(Clock::now() - wall_begin_).count();
    cpu_s_ += static_cast<double>(std::clock() - cpu_begin_) / CLOCKS_PER_SEC;
  }
  PartTimer(const PartTimer&) = delete;
  PartTimer& operator=(const PartTimer&) = delete;
  PartTimer(PartTimer&&) = delete;
  PartTimer& operator=(PartTimer&&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  double& wall_s_;
  double& cpu_s_;
  Clock::time_point wall_begin_ = Clock::now();
  std::clock_t cpu_begin_ = std::clock();
};

GraphStart choose_start(const PoseGraph& graph, const GraphOptimisationOptions& options) {
  if (options.start) return make_start(graph, *options.start);
  // Graduated non-convexity begins there whatever the start: false closures mislead every other
  // one.
  if (options.gnc && options.gnc->start_from_odometry) {
    return make_start(graph, Initialisation::kOdometryChain);
  }
  return best_start(graph, options.poses_given);
}

template <typename Solution>
void go_to(const Solution& solution, PoseGraph& graph) {
  graph.poses = solution.poses;
  graph.landmarks = solution.landmarks;
}

/// The graph without the edges that a robust solution set aside.
PoseGraph kept_part(const PoseGraph& graph, const std::vector<double>& weights) {
  PoseGraph kept = graph;
  kept.edges.clear();
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (i >= weights.size() || weights[i] >= kSetAsideBelow) kept.edges.push_back(graph.edges[i]);
  }
  return kept;
}

std::size_t closures_of(const PoseGraph& graph) {
  return static_cast<std::size_t>(
      std::ranges::count(graph.edges, EdgeKind::kLoopClosure, &RelativePoseEdge::kind));
}

}  // namespace

GraphOptimisation optimize_graph(const PoseGraph& graph, const GraphOptimisationOptions& options) {
  check_graph(graph);
  GraphOptimisation result;
  GraphOptimisationTimes& times = result.times;
  PoseGraph at = graph;

  const auto begin = [&] {
    const PartTimer timer(times.start_s, times.cpu_s);
    result.start = choose_start(at, options);
    go_to(result.start, at);
  };
  const auto solve = [&] {
    const PartTimer timer(times.solve_s, times.cpu_s);
    result.solved = options.gnc
                        ? optimize_gnc(at, *options.gnc, options.solver, options.stop).solved
                        : optimize(at, options.solver, options.stop);
    result.solved.cost_initial = result.start.cost;
    go_to(result.solved, at);
  };
  const auto certify = [&] {
    const PartTimer timer(times.certify_s, times.cpu_s);
    const PoseGraph kept = kept_part(at, result.solved.edge_weights);
    result.certified = optimize_certified(kept, *options.certificate, options.stop);
    Certificate& certificate = result.certified->certificate;
    certificate.edges_set_aside = at.edges.size() - kept.edges.size();
    certificate.closures_set_aside = closures_of(at) - closures_of(kept);
  };

  begin();
  if (!options.certificate) {
    solve();
  } else if (options.is_robust()) {
    // Which edges count is what a robust kernel finds out; only then is there something to prove.
    solve();
    if (!is_stopped(options.stop)) certify();
  } else {
    certify();
    go_to(*result.certified, at);
    solve();
  }
  result.interrupted = is_stopped(options.stop);
  return result;
}

std::size_t edges_set_aside(const SolveResult& solved) {
  return static_cast<std::size_t>(
      std::count_if(solved.edge_weights.begin(), solved.edge_weights.end(),
                    [](double weight) { return weight < kSetAsideBelow; }));
}

}  // namespace loopstone
