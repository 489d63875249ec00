#include "loopstone/graph/optimize_graph.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "support/manhattan_graph.hpp"

namespace loopstone {
namespace {

using test::manhattan_graph;

PoseGraph city() { return manhattan_graph({.nodes = 200, .blocks = 2}, Rng(1)).graph; }

/// The city with closures that join what lies apart.
PoseGraph with_false_closures(PoseGraph graph, int count) {
  for (int i = 0; i < count; ++i) {
    RelativePoseEdge edge{NodeId{7 * i}, NodeId{199 - 11 * i}, Pose2{0.3 * i, -1.0, 0.5 * i}};
    edge.information = graph.edges.front().information;
    edge.kind = EdgeKind::kLoopClosure;
    graph.edges.push_back(edge);
  }
  return graph;
}

void expect_same(const std::vector<Pose2>& a, const std::vector<Pose2>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].x, b[i].x) << i;
    EXPECT_EQ(a[i].y, b[i].y) << i;
    EXPECT_EQ(a[i].yaw, b[i].yaw) << i;
  }
}

TEST(OptimizeGraph, IsTheSolutionFromTheCheapestStart) {
  PoseGraph graph = city();
  const GraphOptimisation found = optimize_graph(graph);
  const GraphStart start = best_start(graph, true);
  EXPECT_EQ(found.start.initialisation, start.initialisation);
  EXPECT_EQ(found.start.cost, start.cost);
  EXPECT_EQ(found.solved.cost_initial, start.cost);
  graph.poses = start.poses;
  expect_same(found.solved.poses, optimize(graph).poses);
  EXPECT_FALSE(found.certified);
  EXPECT_EQ(found.iterations(), found.solved.iterations);
}

TEST(OptimizeGraph, OwnPosesAreACandidateOnlyWhenTheyMeanSomething) {
  PoseGraph graph = city();
  graph.poses = optimize(graph).poses;
  EXPECT_EQ(optimize_graph(graph).start.initialisation, Initialisation::kAsGiven);
  EXPECT_NE(optimize_graph(graph, {.poses_given = false}).start.initialisation,
            Initialisation::kAsGiven);
  EXPECT_EQ(optimize_graph(graph, {.start = Initialisation::kSpanningTree}).start.initialisation,
            Initialisation::kSpanningTree);
}

TEST(OptimizeGraph, ACertifiedSolutionBeginsAtTheCertifiedMinimum) {
  PoseGraph graph = city();
  const GraphOptimisation found = optimize_graph(graph, {.certificate = CertificateOptions{}});
  ASSERT_TRUE(found.certified);
  EXPECT_TRUE(found.certified->certificate.certified());
  EXPECT_EQ(found.certified->certificate.edges, graph.edges.size());
  EXPECT_TRUE(found.certified->certificate.is_of_whole_graph());
  EXPECT_FALSE(found.interrupted);
  EXPECT_EQ(found.iterations(), found.solved.iterations + found.certified->iterations);
  // The cost at the start is that of the start, not of the certified minimum.
  EXPECT_EQ(found.solved.cost_initial, found.start.cost);
  graph.poses = found.certified->poses;
  expect_same(found.solved.poses, optimize(graph).poses);
}

TEST(OptimizeGraph, WithRobustWeightsWhatWasKeptIsCertifiedInTheEnd) {
  const PoseGraph graph = with_false_closures(city(), 8);
  GraphOptimisationOptions options;
  options.gnc = GncOptions{};
  options.certificate = CertificateOptions{};
  const GraphOptimisation found = optimize_graph(graph, options);
  EXPECT_EQ(found.start.initialisation, Initialisation::kOdometryChain);
  EXPECT_GE(edges_set_aside(found.solved), 8U);
  for (std::size_t i = graph.edges.size() - 8; i < graph.edges.size(); ++i) {
    EXPECT_LT(found.solved.edge_weights[i], kSetAsideBelow) << i;
  }
  ASSERT_TRUE(found.certified);
  EXPECT_EQ(found.certified->certificate.edges, graph.edges.size() - edges_set_aside(found.solved));
  EXPECT_TRUE(found.certified->certificate.certified());
  EXPECT_FALSE(found.certified->certificate.is_of_whole_graph());
  EXPECT_EQ(found.certified->certificate.edges_set_aside, edges_set_aside(found.solved));
  EXPECT_EQ(found.certified->certificate.closures_set_aside, edges_set_aside(found.solved));
  // All edges alike, the false ones tear the city apart.
  EXPECT_GT(optimize_graph(graph).solved.cost, 10.0 * found.solved.robust_cost);
}

TEST(OptimizeGraph, AKernelOfTheSolverIsRobustToo) {
  const PoseGraph graph = with_false_closures(city(), 3);
  GraphOptimisationOptions options;
  options.certificate = CertificateOptions{};
  options.start = Initialisation::kOdometryChain;
  EXPECT_FALSE(options.is_robust());
  options.solver.robust_kernel = RobustKernel::kDcs;
  EXPECT_TRUE(options.is_robust());
  const GraphOptimisation found = optimize_graph(graph, options);
  EXPECT_GE(edges_set_aside(found.solved), 3U);
  EXPECT_EQ(found.certified->certificate.edges, graph.edges.size() - edges_set_aside(found.solved));
}

TEST(OptimizeGraph, EndsWhereItIsAskedToStop) {
  const PoseGraph graph = with_false_closures(city(), 8);
  for (const bool gnc : {false, true}) {
    GraphOptimisationOptions options;
    options.start = Initialisation::kOdometryChain;
    options.certificate = CertificateOptions{};
    if (gnc) options.gnc = GncOptions{};
    int asked = 0;
    options.stop = [&asked] {
      ++asked;
      return false;
    };
    EXPECT_FALSE(optimize_graph(graph, options).interrupted);
    EXPECT_GT(asked, 5) << gnc;
    for (const int after : {0, 1, asked / 2, asked - 1}) {
      int left = after;
      int too_often = 0;
      options.stop = [&] {
        if (left == 0) ++too_often;
        return left == 0 || --left < 0;
      };
      const GraphOptimisation found = optimize_graph(graph, options);
      EXPECT_TRUE(found.interrupted) << gnc << ' ' << after;
      EXPECT_EQ(found.solved.poses.size(), graph.poses.size());
      // Every loop ends the first time that it hears it.
      EXPECT_LT(too_often, 20) << gnc << ' ' << after;
    }
  }
  const SolveResult at_once = optimize(graph, {}, [] { return true; });
  EXPECT_EQ(at_once.status, SolveStatus::kNotConverged);
  EXPECT_EQ(at_once.iterations, 0);
  expect_same(at_once.poses, graph.poses);
}

TEST(OptimizeGraph, TimesCoverTheParts) {
  const GraphOptimisation found = optimize_graph(city(), {.certificate = CertificateOptions{}});
  EXPECT_GT(found.times.start_s, 0.0);
  EXPECT_GT(found.times.certify_s, 0.0);
  EXPECT_GT(found.times.solve_s, 0.0);
  EXPECT_EQ(found.times.wall_s(),
            found.times.start_s + found.times.certify_s + found.times.solve_s);
}

TEST(OptimizeGraph, RefusesWhatCheckGraphRefuses) {
  PoseGraph graph = city();
  graph.edges[3].to.index = 100000;
  EXPECT_THROW((void)optimize_graph(graph), UsageError);
  graph = city();
  graph.edges[3].from_T_to.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)optimize_graph(graph), UsageError);
  EXPECT_EQ(optimize_graph(PoseGraph{}).solved.cost, 0.0);
}

}  // namespace
}  // namespace loopstone
