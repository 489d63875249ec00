// How long a pose graph takes: whole solutions, one factorisation, and a graph that grows while it is solved.
//   bench_graph [FILE.g2o ...]   files are solved from their spanning tree, beside the simulated cities

#include <benchmark/benchmark.h>

#include <filesystem>
#include <string>
#include <vector>

#include "graph/block_cholesky.hpp"
#include "graph/normal_equations.hpp"
#include "loopstone/formats/g2o.hpp"
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
      SolveResult result = optimize(graph, {.relative_tolerance = 1e-4, .robust_kernel = "huber"});
      graph.poses = std::move(result.poses);
      steps += result.iterations;
    }
  }
  state.counters["steps"] = steps;
}
BENCHMARK(grow_city)->Arg(4000)->Unit(benchmark::kMillisecond);

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
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
