// What a key scan costs while a pose graph grows, printed as JSON:
//   measure_incremental FILE.g2o [OPTION=VALUE ...]      options as in IncrementalOptions
// The file's poses are appended one by one, each by its edge from the pose before; all other edges
// between it and earlier poses are its closures, added at once. CPU time of one thread.

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "answers.hpp"
#include "loopstone/formats/g2o.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/graph/incremental_solver.hpp"

namespace loopstone::bench {
namespace {

constexpr std::size_t kLast = 1000;

/// One pose of the file with what was measured when it was reached.
struct KeyScan {
  NodeId from;
  Pose2 from_T_new;
  Eigen::Matrix3d information;
  EdgeKind kind = EdgeKind::kOdometry;
  std::vector<RelativePoseEdge> closures;
};

std::vector<KeyScan> key_scans(const PoseGraph& graph) {
  std::vector<std::vector<RelativePoseEdge>> edges_at(graph.poses.size());
  for (const RelativePoseEdge& edge : graph.edges) {
    edges_at[static_cast<std::size_t>(std::max(edge.from.index, edge.to.index))].push_back(edge);
  }
  std::vector<KeyScan> scans;
  for (std::size_t i = 1; i < edges_at.size(); ++i) {
    std::vector<RelativePoseEdge>& edges = edges_at[i];
    auto way = std::find_if(edges.begin(), edges.end(), [i](const RelativePoseEdge& e) {
      return e.to.index == static_cast<int>(i) && e.from.index == static_cast<int>(i) - 1;
    });
    if (way == edges.end()) throw std::runtime_error("a pose without an edge from the one before");
    KeyScan scan{way->from, way->from_T_to, way->information, way->kind, {}};
    edges.erase(way);
    scan.closures = std::move(edges);
    scans.push_back(std::move(scan));
  }
  return scans;
}

struct Cost {
  double seconds = 0.0;
  bool closed = false;
  IncrementalUpdate update;
};

double quantile(const std::vector<double>& sorted, double share) {
  const auto last = static_cast<double>(sorted.size() - 1);
  return sorted[static_cast<std::size_t>(share * last + 0.5)];
}

template <typename Filter>
void print_times(const char* name, const std::vector<Cost>& costs, std::size_t first,
                 Filter&& filter) {
  std::vector<double> ms;
  double eliminated = 0.0;
  double changed = 0.0;
  double relinearised = 0.0;
  for (std::size_t i = first; i < costs.size(); ++i) {
    if (!filter(costs[i])) continue;
    ms.push_back(1e3 * costs[i].seconds);
    eliminated += static_cast<double>(costs[i].update.poses_eliminated);
    changed += static_cast<double>(costs[i].update.poses_changed);
    relinearised += static_cast<double>(costs[i].update.poses_relinearised);
  }
  std::sort(ms.begin(), ms.end());
  const auto count = static_cast<double>(std::max<std::size_t>(1, ms.size()));
  double sum = 0.0;
  for (const double value : ms) sum += value;
  if (ms.empty()) ms.push_back(0.0);
  std::printf(
      "\"%s\": {\"count\": %.0f, \"mean_ms\": %.6f, \"median_ms\": %.6f, \"p90_ms\": %.6f, "
      "\"p99_ms\": %.6f, \"max_ms\": %.6f, \"eliminated\": %.1f, \"changed\": %.1f, "
      "\"relinearised\": %.1f}, ",
      name, count, sum / count, quantile(ms, 0.5), quantile(ms, 0.9), quantile(ms, 0.99), ms.back(),
      eliminated / count, changed / count, relinearised / count);
}

void measure(const std::string& path, const IncrementalOptions& options) {
  const PoseGraph graph = read_g2o(path).graph;
  const std::vector<KeyScan> scans = key_scans(graph);
  std::vector<Cost> costs;
  IncrementalSolver solver(graph.poses.front(), options);
  for (const KeyScan& scan : scans) {
    Cost cost;
    cost.closed = !scan.closures.empty();
    const double start = thread_seconds();
    solver.append(scan.from, scan.from_T_new, scan.information, scan.kind);
    if (cost.closed) cost.update = solver.add(scan.closures);
    cost.seconds = thread_seconds() - start;
    costs.push_back(cost);
  }
  const double grown = graph_cost(solver.graph());
  const double start = thread_seconds();
  const double solved = solver.solve({.relative_tolerance = 1e-12}).cost;
  const double solve_ms = 1e3 * (thread_seconds() - start);

  const auto all = [](const Cost&) { return true; };
  const auto closed = [](const Cost& c) { return c.closed; };
  const auto appended = [](const Cost& c) { return !c.closed; };
  const std::size_t late = costs.size() > kLast ? costs.size() - kLast : 0;
  std::printf("{\"poses\": %zu, \"edges\": %zu, ", graph.poses.size(), graph.edges.size());
  print_times("all", costs, 0, all);
  print_times("appends", costs, 0, appended);
  print_times("closures", costs, 0, closed);
  print_times("last", costs, late, all);
  print_times("last_appends", costs, late, appended);
  print_times("last_closures", costs, late, closed);
  std::printf("\"cost\": %.9g, \"solved_cost\": %.9g, \"solve_ms\": %.3f}\n", grown, solved,
              solve_ms);
}

}  // namespace
}  // namespace loopstone::bench

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "measure_incremental FILE.g2o [OPTION=VALUE ...]\n");
    return 2;
  }
  try {
    loopstone::IncrementalOptions options;
    std::vector<loopstone::OptionProblem> problems;
    for (int i = 2; i < argc; ++i) {
      for (auto& problem : loopstone::apply_assignment(list_options(options), argv[i]))
        problems.push_back(std::move(problem));
    }
    if (!problems.empty()) throw loopstone::OptionsError(std::move(problems));
    loopstone::bench::measure(argv[1], options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
