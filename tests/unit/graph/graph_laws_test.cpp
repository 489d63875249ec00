// What must hold for every solution, whatever the graph.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "loopstone/base/rng.hpp"
#include "loopstone/graph/initial_poses.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/graph/solver.hpp"
#include "support/manhattan_graph.hpp"

namespace loopstone {
namespace {

const SolverOptions kExactly{.relative_tolerance = 1e-13};

double farthest(const std::vector<Pose2>& a, const std::vector<Pose2>& b) {
  double result = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    result = std::max({result, std::abs(a[i].x - b[i].x), std::abs(a[i].y - b[i].y),
                       std::abs(wrap_angle(a[i].yaw - b[i].yaw))});
  }
  return result;
}

Eigen::Matrix3d random_information(Rng& rng) {
  Eigen::Matrix3d a;
  for (int i = 0; i < 9; ++i) a(i) = rng.uniform(-1.0, 1.0);
  return 100.0 * (a * a.transpose() + 0.5 * Eigen::Matrix3d::Identity());
}

PoseGraph random_graph(std::uint64_t seed) {
  PoseGraph graph = test::manhattan_graph({.nodes = 120, .blocks = 2}, Rng(seed)).graph;
  Rng rng(seed + 100);
  for (RelativePoseEdge& edge : graph.edges) edge.information = random_information(rng);
  return graph;
}

class GraphLaw : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(GraphLaw, OrderOfEdgesDoesNotMatter) {
  PoseGraph graph = random_graph(GetParam());
  const SolveResult expected = optimize(graph, kExactly);
  std::reverse(graph.edges.begin(), graph.edges.end());
  const SolveResult found = optimize(graph, kExactly);
  EXPECT_NEAR(found.cost, expected.cost, 1e-9 * expected.cost);
  EXPECT_LT(farthest(found.poses, expected.poses), 1e-6);
}

TEST_P(GraphLaw, ReversedEdgesWithTransportedInformationAreTheSame) {
  PoseGraph graph = random_graph(GetParam());
  // e = vector(Z^-1 X) of an edge and e' = vector(Z X^-1) of the reversed one: with E = Z^-1 X, E'
  // is Z E^-1 Z^-1, so at e = 0 e' = -Ad(Z) e. Exact for perfect measurements only, so those are
  // compared, from a bad start.
  std::vector<Pose2> truth = initial_poses(graph, Initialisation::kOdometryChain);
  for (RelativePoseEdge& edge : graph.edges) {
    edge.from_T_to = truth[static_cast<std::size_t>(edge.from.index)].inverse() *
                     truth[static_cast<std::size_t>(edge.to.index)];
  }
  PoseGraph reversed = graph;
  for (RelativePoseEdge& edge : reversed.edges) {
    const Eigen::Matrix3d back = adjoint(edge.from_T_to).inverse();
    edge.information = back.transpose() * edge.information * back;
    edge.from_T_to = edge.from_T_to.inverse();
    std::swap(edge.from, edge.to);
  }
  // To first order the costs agree...
  Rng rng(GetParam());
  for (std::size_t i = 1; i < graph.poses.size(); ++i) {
    const Pose2 nudge{rng.uniform(-1e-5, 1e-5), rng.uniform(-1e-5, 1e-5), rng.uniform(-1e-5, 1e-5)};
    graph.poses[i] = truth[i] * nudge;
  }
  reversed.poses = graph.poses;
  EXPECT_NEAR(graph_cost(reversed), graph_cost(graph), 1e-3 * graph_cost(graph));
  // ...and so do the optima.
  EXPECT_LT(farthest(optimize(reversed, kExactly).poses, optimize(graph, kExactly).poses), 1e-6);
}

TEST_P(GraphLaw, SplitInformationIsTheSame) {
  const PoseGraph graph = random_graph(GetParam());
  PoseGraph split = graph;
  split.edges.clear();
  for (RelativePoseEdge edge : graph.edges) {
    const Eigen::Matrix3d information = edge.information;
    edge.information = 0.3 * information;
    split.edges.push_back(edge);
    edge.information = 0.7 * information;
    split.edges.push_back(edge);
  }
  const SolveResult expected = optimize(graph, kExactly);
  const SolveResult found = optimize(split, kExactly);
  EXPECT_NEAR(found.cost, expected.cost, 1e-9 * expected.cost);
  EXPECT_LT(farthest(found.poses, expected.poses), 1e-6);
}

TEST_P(GraphLaw, ACommonMotionMovesTheOptimum) {
  const PoseGraph graph = random_graph(GetParam());
  const Pose2 other_T_map{-7.0, 100.0, -2.0};
  PoseGraph moved = graph;
  for (Pose2& pose : moved.poses) pose = other_T_map * pose;
  const SolveResult expected = optimize(graph, kExactly);
  const SolveResult found = optimize(moved, kExactly);
  std::vector<Pose2> poses = expected.poses;
  for (Pose2& pose : poses) pose = other_T_map * pose;
  EXPECT_NEAR(found.cost, expected.cost, 1e-8 * expected.cost);
  EXPECT_LT(farthest(found.poses, poses), 1e-6);
}

TEST_P(GraphLaw, ATreeHasNoCost) {
  PoseGraph graph = random_graph(GetParam());
  std::erase_if(graph.edges,
                [](const RelativePoseEdge& e) { return e.kind == EdgeKind::kLoopClosure; });
  Rng rng(GetParam());
  for (std::size_t i = 1; i < graph.poses.size(); ++i) {
    Pose2& pose = graph.poses[i];
    pose = pose * Pose2{rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), rng.uniform(-0.1, 0.1)};
  }
  EXPECT_LT(optimize(graph, kExactly).cost, 1e-12);
}

TEST_P(GraphLaw, AnyPoseMayBeTheGauge) {
  PoseGraph graph = random_graph(GetParam());
  const SolveResult expected = optimize(graph, kExactly);
  graph.fixed = {{77}};
  const SolveResult found = optimize(graph, kExactly);
  EXPECT_EQ(found.poses[77], graph.poses[77]);
  EXPECT_NEAR(found.cost, expected.cost, 1e-8 * expected.cost);
}

TEST_P(GraphLaw, OnePriorPlacesTheGraphAndCostsNothing) {
  PoseGraph graph = random_graph(GetParam());
  const double expected = optimize(graph, kExactly).cost;
  Rng rng(GetParam());
  graph.priors = {{{30}, {5.0, -3.0, 2.0}, random_information(rng)}};
  const SolveResult found = optimize(graph, kExactly);
  EXPECT_EQ(found.status, SolveStatus::kConverged);
  EXPECT_NEAR(found.cost, expected, 1e-8 * expected);
  EXPECT_LT(farthest({found.poses[30]}, {{5.0, -3.0, 2.0}}), 1e-6);
}

TEST_P(GraphLaw, MethodsAgree) {
  const PoseGraph graph = random_graph(GetParam());
  const SolveResult expected = optimize(graph, kExactly);
  for (const DescentMethod method : {DescentMethod::kLevenbergMarquardt, DescentMethod::kDogleg}) {
    const SolveResult found = optimize(graph, {.method = method, .relative_tolerance = 1e-13});
    EXPECT_EQ(found.status, SolveStatus::kConverged) << to_string(method);
    EXPECT_NEAR(found.cost, expected.cost, 1e-9 * expected.cost) << to_string(method);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, GraphLaw, ::testing::Values(41U, 42U, 43U));

TEST(Landmarks, ArePutWhereTheyWereSeen) {
  // Three poses on a line that see two points; perfect measurements, bad start.
  PoseGraph graph;
  const std::vector<Pose2> truth{{}, {1.0, 0.2, 0.5}, {2.0, 0.5, -0.7}};
  const std::vector<Eigen::Vector2d> points{{2.0, 3.0}, {-1.0, 2.0}};
  graph.poses = {{}, {1.2, 0.0, 0.4}, {1.8, 0.6, -0.5}};
  graph.landmarks = {{1.5, 3.5}, {-1.5, 2.5}, {7.0, 7.0}};
  const Eigen::Matrix2d information = Eigen::Vector2d(4.0, 9.0).asDiagonal();
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 2; ++k) {
      graph.landmark_edges.push_back(
          {{i},
           {k},
           truth[static_cast<std::size_t>(i)].inverse() * points[static_cast<std::size_t>(k)],
           information});
    }
  }
  const SolveResult result = optimize(graph);
  EXPECT_EQ(result.status, SolveStatus::kConverged);
  EXPECT_EQ(result.components, 1);
  EXPECT_LT(result.cost, 1e-12);
  EXPECT_LT(farthest(result.poses, truth), 1e-6);
  for (std::size_t k = 0; k < 2; ++k) EXPECT_LT((result.landmarks[k] - points[k]).norm(), 1e-6);
  EXPECT_EQ(result.landmarks[2], graph.landmarks[2]) << "nobody sees it";
}

TEST(Landmarks, JacobiansEqualNumericDerivatives) {
  Rng rng(44);
  for (int i = 0; i < 20; ++i) {
    const Pose2 from{rng.uniform(-5.0, 5.0), rng.uniform(-5.0, 5.0), rng.uniform(-kPi, kPi)};
    const Eigen::Vector2d landmark(rng.uniform(-5.0, 5.0), rng.uniform(-5.0, 5.0));
    const LandmarkEdge edge{{0}, {0}, {1.0, 2.0}};
    const LandmarkJacobians j = landmark_jacobians(from, landmark);
    constexpr double kStep = 1e-6;
    for (int k = 0; k < 3; ++k) {
      Eigen::Vector3d d = Eigen::Vector3d::Zero();
      d(k) = kStep;
      const Pose2 more{from.x + d.x(), from.y + d.y(), from.yaw + d.z()};
      const Pose2 less{from.x - d.x(), from.y - d.y(), from.yaw - d.z()};
      const Eigen::Vector2d numeric =
          (landmark_error(edge, more, landmark) - landmark_error(edge, less, landmark)) /
          (2.0 * kStep);
      EXPECT_LT((j.from.col(k) - numeric).norm(), 1e-6);
      if (k == 2) continue;
      const Eigen::Vector2d by_landmark = (landmark_error(edge, from, landmark + d.head<2>()) -
                                           landmark_error(edge, from, landmark - d.head<2>())) /
                                          (2.0 * kStep);
      EXPECT_LT((j.landmark.col(k) - by_landmark).norm(), 1e-6);
    }
  }
}

TEST(Priors, JacobianEqualsNumericDerivatives) {
  const PosePrior prior{{0}, {1.0, 2.0, 2.5}};
  const Pose2 pose{0.5, -1.0, -3.0};
  const Eigen::Matrix3d j = prior_jacobian(prior);
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 3; ++k) {
    Eigen::Vector3d d = Eigen::Vector3d::Zero();
    d(k) = kStep;
    const Eigen::Vector3d numeric =
        (prior_error(prior, {pose.x + d.x(), pose.y + d.y(), pose.yaw + d.z()}) -
         prior_error(prior, {pose.x - d.x(), pose.y - d.y(), pose.yaw - d.z()})) /
        (2.0 * kStep);
    EXPECT_LT((j.col(k) - numeric).norm(), 1e-6);
  }
}

TEST(RobustKernels, DcsIsDynamicCovarianceScaling) {
  // Agarwal et al. 2013, eq. 15: s = min(1, 2 phi / (phi + chi2)), the information scaled by s^2.
  for (const double chi2 : {0.1, 1.0, 4.0, 5.0, 100.0}) {
    const double s = std::min(1.0, 2.0 * 4.0 / (4.0 + chi2));
    EXPECT_DOUBLE_EQ(evaluate(RobustKernel::kDcs, 2.0, chi2).weight, s * s);
    const double slope = (evaluate(RobustKernel::kDcs, 2.0, chi2 + 1e-5).cost -
                          evaluate(RobustKernel::kDcs, 2.0, chi2 - 1e-5).cost) /
                         2e-5;
    EXPECT_NEAR(slope, s * s, 1e-4);
  }
}

}  // namespace
}  // namespace loopstone
