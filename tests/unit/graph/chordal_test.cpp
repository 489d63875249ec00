#include "graph/chordal.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "graph/isotropic_descent.hpp"
#include "loopstone/graph/initial_poses.hpp"
#include "support/manhattan_graph.hpp"

namespace loopstone {
namespace {

using test::manhattan_graph;
using test::SimulatedGraph;

void expect_near(const std::vector<Pose2>& actual, const std::vector<Pose2>& expected,
                 double tolerance) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    EXPECT_NEAR(actual[i].x, expected[i].x, tolerance) << i;
    EXPECT_NEAR(actual[i].y, expected[i].y, tolerance) << i;
    EXPECT_NEAR(wrap_angle(actual[i].yaw - expected[i].yaw), 0.0, tolerance) << i;
  }
}

TEST(Chordal, ReproducesATruthThatWasMeasuredPerfectly) {
  const SimulatedGraph world =
      manhattan_graph({.nodes = 200, .blocks = 3, .sigma_xy_m = 0.0, .sigma_yaw_rad = 0.0}, Rng(1));
  PoseGraph graph = world.graph;
  for (std::size_t i = 1; i < graph.poses.size(); ++i) graph.poses[i] = {7.0, -3.0, 2.0};
  expect_near(initial_poses(graph, Initialisation::kChordal), world.truth, 1e-8);
}

TEST(Chordal, KeepsTheHeldPose) {
  PoseGraph graph = manhattan_graph({.nodes = 100, .blocks = 2}, Rng(2)).graph;
  graph.fixed = {{40}};
  graph.poses[40] = {12.0, 13.0, 1.5};
  for (const Initialisation kind :
       {Initialisation::kChordal, Initialisation::kSpanningTree, Initialisation::kOdometryChain}) {
    const std::vector<Pose2> poses = initial_poses(graph, kind);
    EXPECT_NEAR(poses[40].x, 12.0, 1e-12);
    EXPECT_NEAR(poses[40].yaw, 1.5, 1e-12);
    EXPECT_GT((poses[0].translation() - graph.poses[0].translation()).norm(), 1.0);
  }
}

TEST(Chordal, IsBetterThanDeadReckoningAndBestStartTakesIt) {
  const SimulatedGraph world =
      manhattan_graph({.nodes = 1000, .blocks = 5, .sigma_yaw_rad = 0.03}, Rng(3));
  const GraphStart chain = make_start(world.graph, Initialisation::kOdometryChain);
  const GraphStart chordal = make_start(world.graph, Initialisation::kChordal);
  EXPECT_LT(chordal.cost, 0.01 * chain.cost);
  const GraphStart best = best_start(world.graph, true);
  EXPECT_EQ(best.initialisation, Initialisation::kChordal);
  EXPECT_EQ(best.poses, chordal.poses);
}

TEST(Chordal, BestStartKeepsASolutionThatIsGiven) {
  SimulatedGraph world = manhattan_graph({.nodes = 200, .blocks = 3}, Rng(4));
  world.graph.poses = world.truth;
  const GraphStart best = best_start(world.graph, true);
  EXPECT_LE(best.cost, graph_cost(world.graph));
  const GraphStart blind = best_start(world.graph, false);
  EXPECT_NE(blind.initialisation, Initialisation::kAsGiven);
}

TEST(Chordal, PriorsPlaceAGraph) {
  const SimulatedGraph world =
      manhattan_graph({.nodes = 50, .blocks = 2, .sigma_xy_m = 0.0, .sigma_yaw_rad = 0.0}, Rng(5));
  PoseGraph graph = world.graph;
  const Pose2 map_T_world{3.0, 4.0, 1.0};
  graph.priors.push_back({{20}, map_T_world * world.truth[20], Eigen::Matrix3d::Identity()});
  std::vector<Pose2> expected = world.truth;
  for (Pose2& pose : expected) pose = map_T_world * pose;
  for (const Initialisation kind :
       {Initialisation::kChordal, Initialisation::kSpanningTree, Initialisation::kOdometryChain}) {
    // The prior weighs a millionth of an edge, so that much of the digits is lost.
    expect_near(initial_poses(graph, kind), expected, 1e-6);
  }
}

TEST(Chordal, LandmarksAreWhereTheyAreSeen) {
  PoseGraph graph;
  graph.poses = {{0.0, 0.0, 0.0}, {2.0, 0.0, 0.5 * kPi}};
  graph.landmarks = {{9.0, 9.0}, {5.0, 6.0}};
  graph.landmark_edges = {{{0}, {0}, {1.0, 1.0}}, {{1}, {0}, {1.0, 1.0}}};
  const auto landmarks = initial_landmarks(graph);
  EXPECT_NEAR((landmarks[0] - Eigen::Vector2d(1.0, 1.0)).norm(), 0.0, 1e-12);
  EXPECT_EQ(landmarks[1], graph.landmarks[1]) << "nobody sees it";
}

TEST(IsotropicDescent, EndsWhereNoSmallStepLowersTheCost) {
  const SimulatedGraph world = manhattan_graph({.nodes = 150, .blocks = 2}, Rng(6));
  const IsotropicSystem system = isotropic_system(world.graph);
  const PositionSolver positions(system);
  const IsotropicDescentResult result = descend_isotropic(
      system, chordal_state(system, positions, state_of(world.graph, system.problem)));
  EXPECT_TRUE(result.converged);
  EXPECT_LE(result.iterations, 8);
  EXPECT_EQ(result.cost, isotropic_cost(system.problem, result.state));
  for (std::size_t i = 1; i < 150; i += 13) {
    for (const double step : {-1e-4, 1e-4}) {
      IsotropicState moved = result.state;
      moved.heading[i] *= std::polar(1.0, step);
      EXPECT_GT(isotropic_cost(system.problem, moved), result.cost);
      moved = result.state;
      moved.position[i] += Complex(0.0, step);
      EXPECT_GT(isotropic_cost(system.problem, moved), result.cost);
    }
  }
  // Positions of least cost are those that the descent found, too.
  IsotropicState again = result.state;
  positions.solve(again);
  EXPECT_NEAR(isotropic_cost(system.problem, again), result.cost, 1e-9 * result.cost);
}

}  // namespace
}  // namespace loopstone
