#include "loopstone/graph/incremental_solver.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "loopstone/base/error.hpp"
#include "support/manhattan_graph.hpp"

namespace loopstone {
namespace {

using test::manhattan_graph;
using test::SimulatedGraph;

double farthest(const std::vector<Pose2>& a, const std::vector<Pose2>& b) {
  double result = a.size() == b.size() ? 0.0 : 1e9;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    result = std::max({result, std::abs(a[i].x - b[i].x), std::abs(a[i].y - b[i].y),
                       std::abs(wrap_angle(a[i].yaw - b[i].yaw))});
  }
  return result;
}

/// Feeds a graph pose by pose, as a mapper would; calls after(solver) after each closure.
template <typename After>
IncrementalSolver replay(const PoseGraph& graph, const IncrementalOptions& options, After&& after) {
  IncrementalSolver solver(graph.poses.front(), options);
  for (const RelativePoseEdge& edge : graph.edges) {
    if (edge.kind == EdgeKind::kOdometry) {
      solver.append(edge.from, edge.from_T_to, edge.information);
    } else {
      (void)solver.add(edge);
      after(solver);
    }
  }
  return solver;
}

TEST(IncrementalSolver, EqualsTheBatchSolverAtEachStepWhenNothingIsNeglected) {
  const SimulatedGraph world = manhattan_graph({.nodes = 150, .blocks = 2}, Rng(21));
  const IncrementalOptions exact{.relinearise_m = 0.0,
                                 .relinearise_rad = 0.0,
                                 .relinearise_every = 1,
                                 .negligible_change = 0.0,
                                 .wait_updates = 1};
  int steps = 0;
  replay(world.graph, exact, [&](IncrementalSolver& solver) {
    if (++steps % 5 != 0) return;
    // Two more rounds without news: an update of nothing still linearises anew.
    for (int i = 0; i < 4; ++i) (void)solver.add(std::vector<RelativePoseEdge>{});
    const SolveResult batch = optimize(solver.graph(), {.relative_tolerance = 1e-13});
    EXPECT_LT(farthest(solver.poses(), batch.poses), 1e-6) << steps;
  });
  EXPECT_GT(steps, 20);
}

/// The same key scan by key scan: all closures of a pose at once.
template <typename After>
IncrementalSolver replay_key_scans(const PoseGraph& graph, const IncrementalOptions& options,
                                   After&& after) {
  IncrementalSolver solver(graph.poses.front(), options);
  std::vector<RelativePoseEdge> closures;
  const auto close = [&] {
    if (!closures.empty()) after(solver, solver.add(closures));
    closures.clear();
  };
  for (const RelativePoseEdge& edge : graph.edges) {
    if (edge.kind == EdgeKind::kOdometry) {
      close();
      solver.append(edge.from, edge.from_T_to, edge.information);
    } else {
      closures.push_back(edge);
    }
  }
  close();
  return solver;
}

TEST(IncrementalSolver, StaysCloseToTheOptimumByDefault) {
  const SimulatedGraph world = manhattan_graph({.nodes = 600, .blocks = 4}, Rng(22));
  double farthest_off = 0.0;
  double worst_ratio = 1.0;
  const IncrementalSolver solver =
      replay_key_scans(world.graph, {}, [&](IncrementalSolver& s, const IncrementalUpdate&) {
        if (s.poses().size() % 10 != 0) return;
        const SolveResult batch = optimize(s.graph());
        farthest_off = std::max(farthest_off, farthest(s.poses(), batch.poses));
        // A few edges cost next to nothing, whatever the ratio.
        if (batch.cost > 100.0) {
          worst_ratio = std::max(worst_ratio, graph_cost(s.graph()) / batch.cost);
        }
      });
  EXPECT_LT(farthest_off, 0.2);
  EXPECT_GT(worst_ratio, 1.0);
  EXPECT_LT(worst_ratio, 1.1);
  EXPECT_EQ(solver.poses().size(), world.graph.poses.size());
  EXPECT_EQ(solver.graph().edges.size(), world.graph.edges.size());
}

TEST(IncrementalSolver, ClosuresThatAgreeWaitAndCostNoMoreThanAllowed) {
  const SimulatedGraph world = manhattan_graph(
      {.nodes = 400, .blocks = 3, .sigma_xy_m = 0.005, .sigma_yaw_rad = 0.002}, Rng(27));
  const auto run = [&](const IncrementalOptions& options) {
    std::size_t waited = 0;
    std::size_t in_a_row = 0;
    std::size_t longest = 0;
    IncrementalSolver solver = replay_key_scans(
        world.graph, options, [&](IncrementalSolver&, const IncrementalUpdate& update) {
          waited += update.waits ? 1 : 0;
          in_a_row = update.waits ? in_a_row + 1 : 0;
          longest = std::max(longest, in_a_row);
          if (update.waits) {
            EXPECT_EQ(update.poses_eliminated, 0U);
          }
        });
    EXPECT_LT(longest, static_cast<std::size_t>(options.wait_updates));
    // An update of nothing brings in what waits.
    for (int i = 0; i < 4; ++i) EXPECT_FALSE(solver.add(std::vector<RelativePoseEdge>{}).waits);
    const double batch = optimize(solver.graph(), {.relative_tolerance = 1e-12}).cost;
    EXPECT_LT(graph_cost(solver.graph()), 1.02 * batch);
    return waited;
  };
  EXPECT_EQ(run({.wait_updates = 1}), 0U);
  EXPECT_EQ(run({.wait_chi2 = 0.0}), 0U);
  const std::size_t some = run({.wait_chi2 = 5.0, .wait_updates = 4});
  EXPECT_GT(some, 20U);
  EXPECT_GT(run({.wait_chi2 = 50.0, .wait_updates = 50}), some);
}

TEST(IncrementalSolver, ClosuresThatDisagreeDoNotWait) {
  IncrementalSolver solver(Pose2{});
  NodeId last{0};
  const Eigen::Matrix3d information = 100.0 * Eigen::Matrix3d::Identity();
  for (int i = 0; i < 10; ++i) last = solver.append(last, {1.0, 0.0, 0.0}, information);
  const RelativePoseEdge agrees{{2}, last, {8.0, 0.01, 0.0}, information, EdgeKind::kLoopClosure};
  EXPECT_TRUE(solver.add(agrees).waits);
  // The newest pose is where its two edges want it, half way.
  EXPECT_NEAR(solver.poses().back().y, 0.005, 1e-3);
  RelativePoseEdge disagrees = agrees;
  disagrees.from_T_to.y = 1.0;
  EXPECT_FALSE(solver.add(disagrees).waits);
  EXPECT_LT(graph_cost(solver.graph()), 1.01 * optimize(solver.graph()).cost);
}

TEST(IncrementalSolver, ChangesThatTravelInSlicesArrive) {
  const SimulatedGraph world = manhattan_graph({.nodes = 300, .blocks = 3}, Rng(28));
  const auto nothing = [](IncrementalSolver&, const IncrementalUpdate&) {};
  const IncrementalOptions at_once{.negligible_change = 0.0, .poses_at_once = 1'000'000};
  const IncrementalOptions in_slices{.negligible_change = 0.0, .poses_at_once = 20};
  for (const IncrementalOptions& options : {at_once, in_slices}) {
    IncrementalSolver solver = replay_key_scans(world.graph, options, nothing);
    // Updates without news carry on with what is left.
    for (int i = 0; i < 60; ++i) (void)solver.add(std::vector<RelativePoseEdge>{});
    EXPECT_LT(graph_cost(solver.graph()), 1.01 * optimize(solver.graph()).cost);
  }
}

TEST(IncrementalSolver, SolvesToTheOptimumOfTheBatchAtAnyTime) {
  const SimulatedGraph world = manhattan_graph({.nodes = 300, .blocks = 3}, Rng(23));
  int steps = 0;
  replay(world.graph, {}, [&](IncrementalSolver& solver) {
    if (++steps % 40 != 0) return;
    const double batch = optimize(solver.graph(), {.relative_tolerance = 1e-12}).cost;
    const SolveResult solved = solver.solve({.relative_tolerance = 1e-12});
    EXPECT_NEAR(solved.cost, batch, 1e-9 * batch + 1e-12);
    EXPECT_EQ(solver.poses(), solved.poses);
  });
  EXPECT_GT(steps, 40);
}

TEST(IncrementalSolver, GoesOnFromAGraph) {
  const SimulatedGraph world = manhattan_graph({.nodes = 200, .blocks = 2}, Rng(24));
  PoseGraph start;
  start.poses.assign(world.graph.poses.begin(), world.graph.poses.begin() + 100);
  std::vector<RelativePoseEdge> rest;
  for (const RelativePoseEdge& edge : world.graph.edges) {
    (std::max(edge.from.index, edge.to.index) < 100 ? start.edges : rest).push_back(edge);
  }
  IncrementalSolver solver(start);
  EXPECT_LT(farthest(solver.poses(), optimize(start).poses), 1e-4);
  for (const RelativePoseEdge& edge : rest) {
    if (edge.kind == EdgeKind::kOdometry) {
      solver.append(edge.from, edge.from_T_to, edge.information);
    } else {
      (void)solver.add(edge);
    }
  }
  EXPECT_LT(farthest(solver.poses(), optimize(solver.graph()).poses), 0.05);
}

TEST(IncrementalSolver, AppendingMovesNothingAndClosingDoes) {
  IncrementalSolver solver(Pose2{1.0, 2.0, 0.5});
  NodeId last{0};
  for (int i = 0; i < 40; ++i) {
    last = solver.append(last, {1.0, 0.0, i % 10 == 9 ? 0.52 * kPi : 0.0},
                         100.0 * Eigen::Matrix3d::Identity());
  }
  const std::vector<Pose2> before = solver.poses();
  const IncrementalUpdate update =
      solver.add({last, {0}, {}, 100.0 * Eigen::Matrix3d::Identity(), EdgeKind::kLoopClosure});
  EXPECT_GE(update.poses_eliminated, 40U);
  EXPECT_EQ(solver.poses().front(), before.front());
  EXPECT_GT(farthest(solver.poses(), before), 0.1);
  EXPECT_LT(graph_cost(solver.graph()), 2.0 * optimize(solver.graph()).cost);
}

TEST(IncrementalSolver, EliminatesOnlyWhatAnEdgeTouches) {
  const SimulatedGraph world = manhattan_graph({.nodes = 1000, .blocks = 6}, Rng(25));
  std::size_t eliminated = 0;
  std::size_t steps = 0;
  IncrementalSolver solver(world.graph.poses.front());
  for (const RelativePoseEdge& edge : world.graph.edges) {
    if (edge.kind == EdgeKind::kOdometry) {
      solver.append(edge.from, edge.from_T_to, edge.information);
    } else {
      const IncrementalUpdate update = solver.add(edge);
      eliminated += update.poses_eliminated;
      if (!update.waits) ++steps;
    }
  }
  EXPECT_LT(eliminated, 150 * steps);
}

TEST(IncrementalSolver, GivesTheSameBytesAgain) {
  const SimulatedGraph world = manhattan_graph({.nodes = 300, .blocks = 3}, Rng(26));
  const auto nothing = [](IncrementalSolver&) {};
  EXPECT_EQ(replay(world.graph, {}, nothing).poses(), replay(world.graph, {}, nothing).poses());
}

TEST(IncrementalSolver, RefusesWhatItCannotHold) {
  IncrementalSolver solver(Pose2{});
  EXPECT_THROW(solver.append({1}, {}, Eigen::Matrix3d::Identity()), UsageError);
  EXPECT_THROW(solver.append({0}, {}, Eigen::Matrix3d::Zero()), UsageError);
  solver.append({0}, {1.0, 0.0, 0.0}, Eigen::Matrix3d::Identity());
  EXPECT_THROW((void)solver.add(RelativePoseEdge{{0}, {2}, {}}), UsageError);
  EXPECT_THROW((void)solver.add(RelativePoseEdge{{1}, {1}, {}}), UsageError);
  EXPECT_EQ(solver.poses().size(), 2U);
  PoseGraph apart;
  apart.poses.resize(2);
  EXPECT_THROW(IncrementalSolver{apart}, UsageError);
}

}  // namespace
}  // namespace loopstone
