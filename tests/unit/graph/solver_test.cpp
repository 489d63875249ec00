#include "loopstone/graph/solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "graph/normal_equations.hpp"
#include "loopstone/base/error.hpp"
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

/// The textbook: every Jacobian written into one dense system.
std::vector<Pose2> dense_gauss_newton(const PoseGraph& graph, int iterations) {
  std::vector<Pose2> poses = graph.poses;
  const auto size = 3 * static_cast<Eigen::Index>(poses.size());
  for (int iteration = 0; iteration < iterations; ++iteration) {
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(size);
    h.topLeftCorner<3, 3>().setIdentity();
    for (const RelativePoseEdge& edge : graph.edges) {
      const Pose2& from = poses[static_cast<std::size_t>(edge.from.index)];
      const Pose2& to = poses[static_cast<std::size_t>(edge.to.index)];
      Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(3, size);
      const EdgeJacobians j = edge_jacobians(edge, from, to);
      if (edge.from.index > 0) jacobian.middleCols<3>(3 * edge.from.index) = j.from;
      if (edge.to.index > 0) jacobian.middleCols<3>(3 * edge.to.index) = j.to;
      h += jacobian.transpose() * edge.information * jacobian;
      g += jacobian.transpose() * edge.information * edge_error(edge, from, to);
    }
    const Eigen::VectorXd step = h.ldlt().solve(-g);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Eigen::Vector3d d = step.segment<3>(3 * static_cast<Eigen::Index>(i));
      poses[i] = {poses[i].x + d.x(), poses[i].y + d.y(), wrap_angle(poses[i].yaw + d.z())};
    }
  }
  return poses;
}

TEST(Optimize, AgreesWithDenseGaussNewton) {
  const SimulatedGraph world = manhattan_graph({.nodes = 80, .blocks = 2}, Rng(1));
  for (const DescentMethod method :
       {DescentMethod::kGaussNewton, DescentMethod::kLevenbergMarquardt, DescentMethod::kDogleg}) {
    const SolveResult result =
        optimize(world.graph, {.method = method, .relative_tolerance = 1e-13});
    EXPECT_EQ(result.status, SolveStatus::kConverged) << to_string(method);
    expect_near(result.poses, dense_gauss_newton(world.graph, 12), 1e-7);
  }
}

TEST(Optimize, RecoversTheTruthFromPerfectMeasurements) {
  SimulatedGraph world =
      manhattan_graph({.nodes = 300, .blocks = 4, .sigma_xy_m = 0.0, .sigma_yaw_rad = 0.0}, Rng(2));
  Rng rng(3);
  for (std::size_t i = 1; i < world.graph.poses.size(); ++i) {
    Pose2& pose = world.graph.poses[i];
    pose = {pose.x + rng.normal(0.0, 0.3), pose.y + rng.normal(0.0, 0.3),
            wrap_angle(pose.yaw + rng.normal(0.0, 0.1))};
  }
  const SolveResult result = optimize(world.graph);
  EXPECT_EQ(result.status, SolveStatus::kConverged);
  EXPECT_LT(result.cost, 1e-9);
  expect_near(result.poses, world.truth, 1e-6);
}

TEST(Optimize, FindsAStationaryPointBelowTheTruth) {
  const SimulatedGraph world = manhattan_graph({.nodes = 1000, .blocks = 6}, Rng(4));
  const SolveResult result = optimize(world.graph);
  PoseGraph truth = world.graph;
  truth.poses = world.truth;
  EXPECT_EQ(result.status, SolveStatus::kConverged);
  EXPECT_LT(result.cost, graph_cost(truth));
  PoseGraph solved = world.graph;
  solved.poses = result.poses;
  EXPECT_NEAR(graph_cost(solved), result.cost, 1e-9 * result.cost);
  EXPECT_NEAR(graph_cost(world.graph), result.cost_initial, 1e-9 * result.cost_initial);
  for (std::size_t i = 1; i < result.poses.size(); i += 37) {
    for (const double step : {-1e-3, 1e-3}) {
      PoseGraph moved = solved;
      moved.poses[i].yaw += step;
      EXPECT_GT(graph_cost(moved), result.cost);
      moved = solved;
      moved.poses[i].x += step;
      EXPECT_GT(graph_cost(moved), result.cost);
    }
  }
}

TEST(Optimize, DoesNotDependOnTheFrame) {
  const SimulatedGraph world = manhattan_graph({.nodes = 200, .blocks = 3}, Rng(5));
  const Pose2 other_T_map{30.0, -20.0, 2.5};
  PoseGraph moved = world.graph;
  for (Pose2& pose : moved.poses) pose = other_T_map * pose;
  const SolveResult here = optimize(world.graph);
  const SolveResult there = optimize(moved);
  EXPECT_NEAR(here.cost, there.cost, 1e-8 * here.cost);
  std::vector<Pose2> expected = here.poses;
  for (Pose2& pose : expected) pose = other_T_map * pose;
  expect_near(there.poses, expected, 1e-6);
}

TEST(Optimize, HoldsTheFirstPose) {
  SimulatedGraph world = manhattan_graph({.nodes = 100, .blocks = 2}, Rng(6));
  EXPECT_EQ(optimize(world.graph).poses.front(), world.graph.poses.front());
}

TEST(Optimize, GivesTheSameBytesAgain) {
  const SimulatedGraph world = manhattan_graph({.nodes = 400, .blocks = 4}, Rng(7));
  EXPECT_EQ(optimize(world.graph).poses, optimize(world.graph).poses);
}

TEST(Optimize, NeverRaisesTheCostFromABadStart) {
  SimulatedGraph world = manhattan_graph({.nodes = 300, .blocks = 4}, Rng(8));
  Rng rng(9);
  for (Pose2& pose : world.graph.poses) {
    pose = {rng.uniform(-20.0, 20.0), rng.uniform(-20.0, 20.0), rng.uniform(-kPi, kPi)};
  }
  for (const RobustKernel kernel : {RobustKernel::kNone, RobustKernel::kHuber,
                                    RobustKernel::kCauchy, RobustKernel::kGemanMcClure}) {
    const SolveResult result = optimize(
        world.graph, {.max_iterations = 30, .robust_kernel = kernel, .robust_everywhere = true});
    EXPECT_LT(result.robust_cost, result.robust_cost_initial) << to_string(kernel);
  }
}

TEST(Optimize, RobustKernelsSetAsideAWrongClosure) {
  SimulatedGraph world = manhattan_graph({.nodes = 300, .blocks = 3}, Rng(10));
  const double clean_cost = optimize(world.graph).cost;
  world.graph.edges.push_back({{10},
                               {250},
                               {7.0, -3.0, 1.0},
                               world.graph.edges.front().information,
                               EdgeKind::kLoopClosure});
  const auto error_of = [&](const std::vector<Pose2>& poses) {
    double worst = 0.0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      worst = std::max(worst, (poses[i].translation() - world.truth[i].translation()).norm());
    }
    return worst;
  };
  const SolveResult plain = optimize(world.graph);
  EXPECT_GT(plain.cost, 5.0 * clean_cost);
  EXPECT_GT(error_of(plain.poses), 1.0);
  for (const RobustKernel kernel :
       {RobustKernel::kHuber, RobustKernel::kCauchy, RobustKernel::kGemanMcClure}) {
    // A start near the truth: kernels that let go have local minima.
    PoseGraph graph = world.graph;
    graph.poses = world.truth;
    const SolveResult robust = optimize(
        graph, {.max_iterations = 1000, .relative_tolerance = 1e-6, .robust_kernel = kernel});
    EXPECT_EQ(robust.status, SolveStatus::kConverged) << to_string(kernel);
    EXPECT_LT(error_of(robust.poses), 0.5) << to_string(kernel);
    EXPECT_LT(robust.edge_weights.back(), 0.05) << to_string(kernel);
    EXPECT_EQ(robust.edge_weights.front(), 1.0) << "odometry is not softened";
  }
}

TEST(Optimize, ReportsSeparateComponentsAndSolvesEach) {
  const SimulatedGraph world = manhattan_graph({.nodes = 60, .blocks = 2}, Rng(11));
  PoseGraph two = world.graph;
  for (const Pose2& pose : world.graph.poses) two.poses.push_back(pose);
  for (RelativePoseEdge edge : world.graph.edges) {
    edge.from.index += 60;
    edge.to.index += 60;
    two.edges.push_back(edge);
  }
  two.poses.push_back({1.0, 2.0, 3.0});  // without any edge
  const SolveResult result = optimize(two);
  EXPECT_EQ(result.status, SolveStatus::kDisconnected);
  EXPECT_EQ(result.components, 3);
  const SolveResult alone = optimize(world.graph);
  expect_near({result.poses.begin(), result.poses.begin() + 60}, alone.poses, 1e-8);
  expect_near({result.poses.begin() + 60, result.poses.begin() + 120}, alone.poses, 1e-8);
  EXPECT_EQ(result.poses.back(), (Pose2{1.0, 2.0, 3.0}));
}

TEST(Optimize, TakesEmptyAndTinyGraphs) {
  EXPECT_EQ(optimize({}).status, SolveStatus::kConverged);
  PoseGraph one;
  one.poses.resize(1);
  EXPECT_EQ(optimize(one).status, SolveStatus::kConverged);
  PoseGraph lonely;
  lonely.poses.resize(3);
  EXPECT_EQ(optimize(lonely).status, SolveStatus::kDisconnected);
  EXPECT_EQ(optimize(lonely).components, 3);
  PoseGraph pair;
  pair.poses.resize(2);
  pair.edges = {{{1}, {0}, {-1.0, 0.0, 0.0}}};
  const SolveResult result = optimize(pair);
  EXPECT_EQ(result.status, SolveStatus::kConverged);
  EXPECT_NEAR(result.poses[1].x, 1.0, 1e-12);
}

TEST(Optimize, RefusesAnUnknownKernelAndBadInformation) {
  PoseGraph graph;
  graph.poses.resize(2);
  graph.edges = {{{0}, {1}, {}, Eigen::Matrix3d::Zero()}};
  EXPECT_THROW((void)optimize(graph), UsageError);
}

TEST(Optimize, SaysWhenTheIterationsRanOut) {
  const SimulatedGraph world = manhattan_graph({.nodes = 300, .blocks = 4}, Rng(12));
  const SolveResult result = optimize(world.graph, {.max_iterations = 1});
  EXPECT_EQ(result.status, SolveStatus::kNotConverged);
  EXPECT_EQ(result.iterations, 1);
  EXPECT_LT(result.cost, result.cost_initial);
}

TEST(InitialPoses, ReproduceATruthThatWasMeasuredPerfectly) {
  const SimulatedGraph world = manhattan_graph(
      {.nodes = 200, .blocks = 3, .sigma_xy_m = 0.0, .sigma_yaw_rad = 0.0}, Rng(13));
  PoseGraph graph = world.graph;
  for (std::size_t i = 1; i < graph.poses.size(); ++i) graph.poses[i] = {};
  expect_near(initial_poses(graph, Initialisation::kOdometryChain), world.truth, 1e-9);
  expect_near(initial_poses(graph, Initialisation::kSpanningTree), world.truth, 1e-9);
}

TEST(InitialPoses, ChainFollowsConsecutiveEdgesAndTreeTheFewest) {
  PoseGraph graph;
  graph.poses.resize(4);
  graph.edges = {{{0}, {1}, {1.0, 0.0, 0.0}},
                 {{2}, {1}, {-1.0, 0.0, 0.0}},
                 {{2}, {3}, {1.0, 0.0, 0.0}},
                 {{0}, {3}, {3.3, 0.0, 0.0}, Eigen::Matrix3d::Identity(), EdgeKind::kLoopClosure}};
  EXPECT_NEAR(initial_poses(graph, Initialisation::kOdometryChain)[3].x, 3.0, 1e-12);
  const auto tree = initial_poses(graph, Initialisation::kSpanningTree);
  EXPECT_NEAR(tree[3].x, 3.3, 1e-12);
  EXPECT_NEAR(tree[2].x, 2.0, 1e-12);
}

TEST(InitialPoses, ChainBridgesAMissingEdge) {
  PoseGraph graph;
  graph.poses.resize(4);
  graph.edges = {
      {{0}, {1}, {1.0, 0.0, 0.0}}, {{0}, {2}, {2.0, 0.0, 0.0}}, {{2}, {3}, {1.0, 0.0, 0.0}}};
  const auto poses = initial_poses(graph, Initialisation::kOdometryChain);
  EXPECT_NEAR(poses[2].x, 2.0, 1e-12);
  EXPECT_NEAR(poses[3].x, 3.0, 1e-12);
}

TEST(NormalEquations, EqualTheSumOverEdgesOfTheirDefinition) {
  SimulatedGraph world = manhattan_graph({.nodes = 40, .blocks = 2}, Rng(14));
  Rng rng(15);
  for (RelativePoseEdge& edge : world.graph.edges) {
    Eigen::Matrix3d a;
    for (int i = 0; i < 9; ++i) a(i) = rng.uniform(-1.0, 1.0);
    edge.information = a * a.transpose() + Eigen::Matrix3d::Identity();
    if (rng.below(2) == 0) {
      std::swap(edge.from, edge.to);
      edge.from_T_to = edge.from_T_to.inverse();
    }
  }
  std::vector<bool> fixed(40, false);
  fixed[0] = true;
  const RobustPolicy policy{RobustKernel::kCauchy, 0.1, true};
  NormalEquations equations(world.graph, fixed, policy);
  (void)equations.linearise({world.graph.poses, {}});

  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(117, 117);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(117);
  for (const RelativePoseEdge& edge : world.graph.edges) {
    const auto from = static_cast<std::size_t>(edge.from.index);
    const auto to = static_cast<std::size_t>(edge.to.index);
    const EdgeJacobians j = edge_jacobians(edge, world.graph.poses[from], world.graph.poses[to]);
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(3, 117);
    if (from > 0) jacobian.middleCols<3>(3 * equations.place_of(from)) = j.from;
    if (to > 0) jacobian.middleCols<3>(3 * equations.place_of(to)) = j.to;
    const Eigen::Vector3d error = edge_error(edge, world.graph.poses[from], world.graph.poses[to]);
    const double weight =
        policy.of(edge.kind == EdgeKind::kLoopClosure, error.dot(edge.information * error)).weight;
    h += weight * jacobian.transpose() * edge.information * jacobian;
    g += weight * jacobian.transpose() * edge.information * error;
  }
  const BlockMatrix& hessian = equations.hessian();
  double found = 0.0;
  for (int j = 0; j < 39; ++j) {
    const auto column = static_cast<std::size_t>(j);
    EXPECT_LT((hessian.diagonal[column] - h.block<3, 3>(3 * j, 3 * j)).norm(), 1e-9);
    EXPECT_LT((equations.gradient()[column] - g.segment<3>(3 * j)).norm(), 1e-9);
    found += hessian.diagonal[column].squaredNorm();
    for (int p = hessian.column_start[column]; p < hessian.column_start[column + 1]; ++p) {
      const auto i = static_cast<std::size_t>(p);
      EXPECT_LT((hessian.below[i] - h.block<3, 3>(3 * hessian.rows[i], 3 * j)).norm(), 1e-9);
      found += 2.0 * hessian.below[i].squaredNorm();
    }
  }
  EXPECT_NEAR(found, h.squaredNorm(), 1e-9 * found) << "no block is missing";
}

}  // namespace
}  // namespace loopstone
