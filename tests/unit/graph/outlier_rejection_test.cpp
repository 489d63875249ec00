#include "loopstone/graph/outlier_rejection.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "graph/supported_closures.hpp"
#include "loopstone/base/rng.hpp"
#include "support/manhattan_graph.hpp"

namespace loopstone {
namespace {

using test::manhattan_graph;

/// Every subset of few nodes.
std::size_t greatest_by_enumeration(const std::vector<std::vector<bool>>& adjacent) {
  std::size_t best = 0;
  const std::size_t size = adjacent.size();
  for (std::size_t set = 0; set < (std::size_t{1} << size); ++set) {
    bool clique = true;
    std::size_t count = 0;
    for (std::size_t i = 0; i < size && clique; ++i) {
      if ((set >> i & 1U) == 0) continue;
      ++count;
      for (std::size_t k = 0; k < i && clique; ++k) {
        clique = (set >> k & 1U) == 0 || adjacent[i][k];
      }
    }
    if (clique) best = std::max(best, count);
  }
  return best;
}

std::vector<std::vector<bool>> random_adjacency(std::size_t size, double density, Rng& rng) {
  std::vector<std::vector<bool>> result(size, std::vector<bool>(size, false));
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      result[i][k] = rng.uniform() < density;
      result[k][i] = result[i][k];
    }
  }
  return result;
}

TEST(GreatestClique, EqualsEnumeration) {
  Rng rng(51);
  for (const double density : {0.0, 0.3, 0.6, 0.9, 1.0}) {
    for (int i = 0; i < 5; ++i) {
      const auto adjacent = random_adjacency(12, density, rng);
      const Clique exact = greatest_clique(adjacent, 100);
      EXPECT_TRUE(exact.exact);
      EXPECT_EQ(exact.nodes.size(), greatest_by_enumeration(adjacent));
      const Clique greedy = greatest_clique(adjacent, 0);
      EXPECT_FALSE(greedy.exact);
      EXPECT_LE(greedy.nodes.size(), exact.nodes.size());
      for (const Clique& clique : {exact, greedy}) {
        for (const int a : clique.nodes) {
          for (const int b : clique.nodes) {
            EXPECT_TRUE(a == b ||
                        adjacent[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)]);
          }
        }
      }
    }
  }
}

/// Adds random closures; returns how many.
std::size_t spoil(PoseGraph& graph, double share, Rng rng) {
  std::size_t closures = 0;
  for (const RelativePoseEdge& edge : graph.edges) closures += edge.kind == EdgeKind::kLoopClosure;
  const auto count =
      static_cast<std::size_t>(std::lround(static_cast<double>(closures) * share / (1.0 - share)));
  for (std::size_t i = 0; i < count; ++i) {
    const int a = static_cast<int>(rng.below(graph.poses.size() / 2));
    const int b = a + 2 + static_cast<int>(rng.below(graph.poses.size() / 2 - 2));
    graph.edges.push_back({{a},
                           {b},
                           {rng.uniform(-8.0, 8.0), rng.uniform(-8.0, 8.0), rng.uniform(-kPi, kPi)},
                           graph.edges.front().information,
                           EdgeKind::kLoopClosure});
  }
  return count;
}

TEST(Gnc, RejectsFalseClosuresAndKeepsTrueOnes) {
  const PoseGraph clean = manhattan_graph({.nodes = 250, .blocks = 2}, Rng(52)).graph;
  const SolveResult expected = optimize(clean);
  for (const double share : {0.2, 0.5}) {
    PoseGraph graph = clean;
    const std::size_t spoilt = spoil(graph, share, Rng(53));
    const GncResult result = optimize_gnc(graph);
    for (std::size_t i = clean.edges.size(); i < graph.edges.size(); ++i) {
      EXPECT_EQ(result.solved.edge_weights[i], 0.0) << i;
      EXPECT_GT(result.edge_chi2[i], 16.0) << i;
    }
    EXPECT_LT(result.rejected, spoilt + 4);
    for (std::size_t i = 0; i < expected.poses.size(); ++i) {
      EXPECT_NEAR(result.solved.poses[i].x, expected.poses[i].x, 0.05);
      EXPECT_NEAR(result.solved.poses[i].y, expected.poses[i].y, 0.05);
    }
  }
}

TEST(Gnc, LeavesACleanGraphAlone) {
  const PoseGraph graph = manhattan_graph({.nodes = 200, .blocks = 3}, Rng(54)).graph;
  const GncResult result = optimize_gnc(graph);
  EXPECT_LE(result.rejected, result.accepted / 50);
  EXPECT_EQ(result.solved.status, SolveStatus::kConverged);
}

TEST(ConsistentClosures, AreTheTrueOnes) {
  PoseGraph graph =
      manhattan_graph({.nodes = 150, .blocks = 2, .closure_share = 0.3}, Rng(55)).graph;
  const std::size_t clean = graph.edges.size();
  const std::size_t closures = clean - 149;
  spoil(graph, 0.5, Rng(56));
  const ConsistentClosures found = consistent_closures(graph, {.exact_up_to = 1000});
  const auto wrong = std::count_if(found.edges.begin(), found.edges.end(),
                                   [clean](std::size_t edge) { return edge >= clean; });
  EXPECT_LE(wrong, 1);
  EXPECT_GT(found.edges.size(), closures * 8 / 10);
}

TEST(SupportedClosures, AreNextToAllTrueOnesAndNextToNoFalseOne) {
  PoseGraph graph = manhattan_graph({.nodes = 400, .blocks = 3}, Rng(57)).graph;
  const std::size_t clean = graph.edges.size();
  const std::size_t planted = spoil(graph, 0.7, Rng(58));
  const std::vector<bool> supported = supported_closures(graph, 25.902);
  const auto true_ones =
      std::count(supported.begin(), supported.begin() + static_cast<std::ptrdiff_t>(clean), true);
  const auto false_ones =
      std::count(supported.begin() + static_cast<std::ptrdiff_t>(clean), supported.end(), true);
  EXPECT_GT(static_cast<double>(true_ones), 0.8 * static_cast<double>(clean - 399));
  EXPECT_LT(static_cast<double>(false_ones), 0.05 * static_cast<double>(planted));
  // Told from the other end, an edge says the same.
  for (RelativePoseEdge& edge : graph.edges) {
    if (edge.kind != EdgeKind::kLoopClosure) continue;
    const Eigen::Matrix3d a = adjoint(edge.from_T_to.inverse());
    edge.information = (a.transpose() * edge.information * a).eval();
    edge.from_T_to = edge.from_T_to.inverse();
    std::swap(edge.from, edge.to);
  }
  EXPECT_EQ(supported_closures(graph, 25.902), supported);
}

}  // namespace
}  // namespace loopstone
