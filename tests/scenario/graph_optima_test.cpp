#include <gtest/gtest.h>

#include <string>

#include "loopstone/formats/g2o.hpp"
#include "loopstone/graph/initial_poses.hpp"
#include "loopstone/graph/solver.hpp"
#include "support/recorded_data.hpp"

namespace loopstone {
namespace {

struct Benchmark {
  std::string name;
  Initialisation initialisation;
  double optimum;
};

/// Public benchmark graphs, and the least sum of e^T information e that is known for them.
class KnownOptimum : public ::testing::TestWithParam<Benchmark> {};

TEST_P(KnownOptimum, IsReached) {
  const std::string file = "graphs/" + GetParam().name + ".g2o";
  const std::string path = test::recorded_data(file);
  if (path.empty()) GTEST_SKIP() << "recorded data is absent: " << file;
  PoseGraph graph = read_g2o(path).graph;
  graph.poses = initial_poses(graph, GetParam().initialisation);
  const SolveResult result = optimize(graph);
  EXPECT_EQ(result.status, SolveStatus::kConverged);
  EXPECT_NEAR(result.cost, GetParam().optimum, 1e-7 * GetParam().optimum);
}

INSTANTIATE_TEST_SUITE_P(
    Graphs, KnownOptimum,
    ::testing::Values(Benchmark{"intel", Initialisation::kOdometryChain, 45.0046958},
                      Benchmark{"intel", Initialisation::kSpanningTree, 45.0046958},
                      Benchmark{"manhattan", Initialisation::kOdometryChain, 3549.03680},
                      Benchmark{"manhattan", Initialisation::kSpanningTree, 3549.03680},
                      Benchmark{"MIT", Initialisation::kSpanningTree, 41.1632688},
                      Benchmark{"city10000", Initialisation::kOdometryChain, 511.985164},
                      Benchmark{"city10000", Initialisation::kSpanningTree, 511.985164}),
    [](const auto& benchmark) {
      return benchmark.param.name +
             (benchmark.param.initialisation == Initialisation::kOdometryChain
                  ? "_from_odometry"
                  : "_from_spanning_tree");
    });

}  // namespace
}  // namespace loopstone
