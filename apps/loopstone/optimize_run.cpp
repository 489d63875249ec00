#include "optimize_run.hpp"

#include <chrono>
#include <cstddef>
#include <ctime>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/graph/initial_poses.hpp"

namespace loopstone::app {

namespace {

using Clock = std::chrono::steady_clock;

double cpu_seconds_since(std::clock_t start) {
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

GraphStart choose_start(const GraphFile& file, const OptimizeRequest& request) {
  const std::string& initial = request.initial;
  if (initial == "best") {
    // Graduated non-convexity begins there whatever the start: false closures mislead every other one.
    if (request.gnc && request.settings.gnc.start_from_odometry) {
      return make_start(file.graph, Initialisation::kOdometryChain);
    }
    return best_start(file.graph, file.has_poses);
  }
  if (initial == "odometry") return make_start(file.graph, Initialisation::kOdometryChain);
  if (initial == "spanning_tree") return make_start(file.graph, Initialisation::kSpanningTree);
  if (initial == "chordal") return make_start(file.graph, Initialisation::kChordal);
  if (!file.has_poses) {
    throw UsageError("--initial file: the file has no VERTEX lines; use best, or chordal");
  }
  return make_start(file.graph, Initialisation::kAsGiven);
}

template <typename Solution>
void take_solution(const Solution& solution, PoseGraph& graph) {
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

}  // namespace

GraphRun optimize_file(GraphFile file, const OptimizeRequest& request) {
  GraphRun run;
  run.file = std::move(file);
  PoseGraph& graph = run.file.graph;

  Clock::time_point begin = Clock::now();
  std::clock_t cpu_begin = std::clock();
  GraphStart start = choose_start(run.file, request);
  run.start_s = seconds_since(begin);
  run.cpu_s = cpu_seconds_since(cpu_begin);
  run.start = start.initialisation;
  run.start_cost = start.cost;

  // What a user would look at without this program.
  const GraphStart before = make_start(
      graph, run.file.has_poses ? Initialisation::kAsGiven : Initialisation::kOdometryChain);
  run.before = before.poses;
  run.before_name = to_string(before.initialisation);
  run.before_cost = before.cost;
  graph.poses = std::move(start.poses);
  graph.landmarks = std::move(start.landmarks);

  const auto solve = [&] {
    cpu_begin = std::clock();
    begin = Clock::now();
    SolveResult result =
        request.gnc ? optimize_gnc(graph, request.settings.gnc, request.settings.solver).solved
                    : optimize(graph, request.settings.solver);
    run.solve_s += seconds_since(begin);
    run.cpu_s += cpu_seconds_since(cpu_begin);
    result.cost_initial = run.start_cost;
    result.iterations += run.solve.iterations;
    take_solution(result, graph);
    run.solve = std::move(result);
  };
  // Which edges count is what a robust kernel finds out; only then is there something to prove.
  const bool robust = request.robust() != "none";
  if (robust || !request.certify) solve();
  if (!request.certify) return run;

  begin = Clock::now();
  cpu_begin = std::clock();
  const PoseGraph kept = kept_part(graph, run.solve.edge_weights);
  run.certified_edges = kept.edges.size();
  run.certified = optimize_certified(kept, request.settings.certificate);
  run.certify_s = seconds_since(begin);
  run.cpu_s += cpu_seconds_since(cpu_begin);
  if (!robust) {
    take_solution(*run.certified, graph);
    solve();
  }
  return run;
}

}  // namespace loopstone::app
