#include <gtest/gtest.h>

#include <string>

#include "loopstone/formats/g2o.hpp"
#include "loopstone/graph/certificate.hpp"
#include "loopstone/graph/initial_poses.hpp"
#include "loopstone/graph/solver.hpp"
#include "support/recorded_data.hpp"

namespace loopstone {
namespace {

struct Benchmark {
  std::string name;
  double isotropic;  ///< optimum that SE-Sync certifies
  double chi2;
};

/// Public benchmark graphs from their edges alone: the certified optimum, and the solution that it
/// leads to.
class CertifiedOptimum : public ::testing::TestWithParam<Benchmark> {};

TEST_P(CertifiedOptimum, IsReachedAndProven) {
  const std::string file = "graphs/" + GetParam().name + ".g2o";
  const std::string path = test::recorded_data(file);
  if (path.empty()) GTEST_SKIP() << "recorded data is absent: " << file;
  PoseGraph graph = read_g2o(path).graph;
  graph.poses = initial_poses(graph, Initialisation::kChordal);
  const CertifiedSolution solution = optimize_certified(graph);
  EXPECT_EQ(solution.certificate.status, CertificateStatus::kCertified);
  EXPECT_NEAR(solution.certificate.cost, GetParam().isotropic, 1e-7 * GetParam().isotropic);
  EXPECT_LE(solution.certificate.optimality_gap, 1e-6 * GetParam().isotropic);
  graph.poses = solution.poses;
  EXPECT_NEAR(optimize(graph).cost, GetParam().chi2, 1e-6 * GetParam().chi2);
}

INSTANTIATE_TEST_SUITE_P(Graphs, CertifiedOptimum,
                         ::testing::Values(Benchmark{"intel", 52.3482273, 45.0046958},
                                           Benchmark{"manhattan", 6431.39139, 3549.03680},
                                           Benchmark{"MIT", 61.1541155, 41.1632688},
                                           Benchmark{"city10000", 638.624619, 511.985164}),
                         [](const auto& benchmark) { return benchmark.param.name; });

/// The poses of MIT's file lead every local method astray.
TEST(MitFromItsFile, IsRejectedWhereItEndsAndThenLeadsToTheOptimum) {
  const std::string path = test::recorded_data("graphs/MIT.g2o");
  if (path.empty()) GTEST_SKIP() << "recorded data is absent";
  PoseGraph graph = read_g2o(path).graph;
  const CertifiedSolution stuck =
      optimize_certified(graph, {.max_iterations = 1000, .max_rank = 1});
  EXPECT_FALSE(stuck.certificate.certified());
  EXPECT_LT(stuck.certificate.min_eigenvalue, -1e-3);
  EXPECT_GT(stuck.certificate.cost, 2.0 * 61.1541155);
  EXPECT_LE(stuck.certificate.lower_bound, 61.1541156);
  const CertifiedSolution free = optimize_certified(graph);
  EXPECT_EQ(free.certificate.status, CertificateStatus::kCertified);
  EXPECT_GE(free.escapes, 1);
  EXPECT_NEAR(free.certificate.cost, 61.1541155, 1e-7 * 61.0);
}

}  // namespace
}  // namespace loopstone
