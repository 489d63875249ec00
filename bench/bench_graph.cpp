// How long a pose graph takes: whole solutions, one factorisation, and a graph that grows while it
// is solved.
//   bench_graph [FILE.g2o ...]   files are solved from their spanning tree and fed pose by pose

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "graph/block_cholesky.hpp"
#include "graph/normal_equations.hpp"
#include "loopstone/formats/g2o.hpp"
#include "loopstone/graph/incremental_solver.hpp"
#include "loopstone/graph/initial_poses.hpp"
#include "loopstone/graph/solver.hpp"
#include "support/manhattan_graph.hpp"

namespace loopstone {
namespace {

PoseGraph city(int nodes) {
  const test::ManhattanOptions options{.nodes = nodes, .blocks = nodes / 250, .closure_share = 0.3};
  return test::manhattan_graph(options, Rng(1)).graph;
}

void solve(benchmark::State& state, const PoseGraph& graph) {
  SolveResult result;
  for (auto _ : state) result = optimize(graph);
  state.counters["nodes"] = static_cast<double>(graph.poses.size());
  state.counters["edges"] = static_cast<double>(graph.edges.size());
  state.counters["steps"] = result.iterations;
  state.counters["cost"] = result.cost;
}

void solve_city(benchmark::State& state) {
  PoseGraph graph = city(static_cast<int>(state.range(0)));
  graph.poses = initial_poses(graph, Initialisation::kSpanningTree);
  solve(state, graph);
}
BENCHMARK(solve_city)->Arg(1000)->Arg(4000)->Arg(10000)->Unit(benchmark::kMillisecond);

void factorise_city(benchmark::State& state) {
  const PoseGraph graph = city(static_cast<int>(state.range(0)));
  std::vector<bool> fixed(graph.poses.size(), false);
  fixed.front() = true;
  NormalEquations equations(graph, fixed, {});
  (void)equations.linearise({graph.poses, {}});
  BlockCholesky cholesky(equations.hessian());
  for (auto _ : state) benchmark::DoNotOptimize(cholesky.factorise(equations.hessian(), 0.0));
  state.counters["fill_blocks"] = static_cast<double>(cholesky.fill());
}
BENCHMARK(factorise_city)->Arg(1000)->Arg(4000)->Arg(10000)->Unit(benchmark::kMillisecond);

/// As a mapper does: 100 solutions while the graph grows, each from the one before.
void grow_city(benchmark::State& state) {
  const PoseGraph whole = city(static_cast<int>(state.range(0)));
  const int nodes = static_cast<int>(whole.poses.size());
  int steps = 0;
  for (auto _ : state) {
    PoseGraph graph;
    steps = 0;
    std::size_t next_edge = 0;
    for (int part = 1; part <= 100; ++part) {
      const int until = nodes * part / 100;
      for (; next_edge < whole.edges.size() && whole.edges[next_edge].to.index < until;
           ++next_edge) {
        const RelativePoseEdge& edge = whole.edges[next_edge];
        if (graph.poses.empty()) graph.poses.push_back(whole.poses.front());
        if (edge.kind == EdgeKind::kOdometry) {
          graph.poses.push_back(graph.poses.back() * edge.from_T_to);
        }
        graph.edges.push_back(edge);
      }
      SolveResult result =
          optimize(graph, {.relative_tolerance = 1e-4, .robust_kernel = RobustKernel::kHuber});
      graph.poses = std::move(result.poses);
      steps += result.iterations;
    }
  }
  state.counters["steps"] = steps;
}
BENCHMARK(grow_city)->Arg(4000)->Unit(benchmark::kMillisecond);

/// A graph fed pose by pose, closures as they come, as a mapper would; times of single scans.
void replay(benchmark::State& state, const PoseGraph& graph) {
  std::vector<std::vector<RelativePoseEdge>> edges_at(graph.poses.size());
  for (const RelativePoseEdge& edge : graph.edges) {
    edges_at[static_cast<std::size_t>(std::max(edge.from.index, edge.to.index))].push_back(edge);
  }
  std::vector<double> times_ms;
  double cost = 0.0;
  for (auto _ : state) {
    times_ms.clear();
    IncrementalSolver solver(graph.poses.front());
    for (std::size_t i = 1; i < edges_at.size(); ++i) {
      const auto begin = std::chrono::steady_clock::now();
      std::vector<RelativePoseEdge> edges = edges_at[i];
      // The edge that leads here: from the pose before, or else from any.
      auto way = std::find_if(edges.begin(), edges.end(), [i](const RelativePoseEdge& e) {
        return std::min(e.from.index, e.to.index) == static_cast<int>(i) - 1;
      });
      if (way == edges.end()) way = edges.begin();
      if (way == edges.end()) {
        state.SkipWithError("a pose without an edge to an earlier one");
        return;
      }
      const bool ahead = way->to.index == static_cast<int>(i);
      solver.append(ahead ? way->from : way->to, ahead ? way->from_T_to : way->from_T_to.inverse(),
                    way->information, way->kind);
      edges.erase(way);
      if (!edges.empty()) (void)solver.add(edges);
      const std::chrono::duration<double, std::milli> elapsed =
          std::chrono::steady_clock::now() - begin;
      times_ms.push_back(elapsed.count());
    }
    cost = graph_cost(solver.graph());
  }
  std::sort(times_ms.begin(), times_ms.end());
  if (times_ms.empty()) return;
  state.counters["median_ms"] = times_ms[times_ms.size() / 2];
  state.counters["p99_ms"] = times_ms[times_ms.size() * 99 / 100];
  state.counters["max_ms"] = times_ms.back();
  state.counters["cost"] = cost;
}

void solve_with(benchmark::State& state, const PoseGraph& graph, DescentMethod method) {
  SolveResult result;
  for (auto _ : state) result = optimize(graph, {.method = method});
  state.counters["steps"] = result.iterations;
  state.counters["cost"] = result.cost;
}

}  // namespace
}  // namespace loopstone

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  for (int i = 1; i < argc; ++i) {
    loopstone::PoseGraph graph = loopstone::read_g2o(argv[i]).graph;
    graph.poses = loopstone::initial_poses(graph, loopstone::Initialisation::kSpanningTree);
    const std::string name = "solve/" + std::filesystem::path(argv[i]).stem().string();
    benchmark::RegisterBenchmark(name.c_str(), [graph](benchmark::State& state) {
      loopstone::solve(state, graph);
    })->Unit(benchmark::kMillisecond);
    using Method = loopstone::DescentMethod;
    for (const Method method : {Method::kLevenbergMarquardt, Method::kDogleg}) {
      const std::string with = name + '/' + std::string(to_string(method));
      benchmark::RegisterBenchmark(with.c_str(), [graph, method](benchmark::State& state) {
        loopstone::solve_with(state, graph, method);
      })->Unit(benchmark::kMillisecond);
    }
    benchmark::RegisterBenchmark(
        ("replay" + name.substr(5)).c_str(),
        [graph](benchmark::State& state) { loopstone::replay(state, graph); })
        ->Unit(benchmark::kMillisecond)
        ->Iterations(1);
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
