#include "loopstone/graph/linearised_graph.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstddef>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/graph/solver.hpp"
#include "support/manhattan_graph.hpp"

namespace loopstone {
namespace {

using Blocks = std::vector<Eigen::Vector3d>;

/// A small city in which two poses see a landmark, and another landmark that nobody sees.
PoseGraph city() {
  PoseGraph graph = test::manhattan_graph({.nodes = 40, .blocks = 1}, Rng(3)).graph;
  graph.landmarks = {{2.0, 1.0}, {50.0, 50.0}};
  graph.landmark_edges.push_back({NodeId{3}, LandmarkId{0}, {0.5, 1.0}});
  graph.landmark_edges.push_back({NodeId{5}, LandmarkId{0}, {-1.0, 0.7}});
  graph.priors.push_back({NodeId{2}, Pose2{2.1, 0.0, 0.1}});
  graph.fixed.push_back(NodeId{7});
  return graph;
}

Eigen::MatrixXd dense(const BlockMatrix& matrix) {
  const auto size = static_cast<Eigen::Index>(matrix.diagonal.size());
  Eigen::MatrixXd full = Eigen::MatrixXd::Zero(3 * size, 3 * size);
  for (Eigen::Index column = 0; column < size; ++column) {
    const auto c = static_cast<std::size_t>(column);
    full.block<3, 3>(3 * column, 3 * column) = matrix.diagonal[c];
    for (int k = matrix.column_start[c]; k < matrix.column_start[c + 1]; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const Eigen::Index row = matrix.rows[at];
      full.block<3, 3>(3 * row, 3 * column) = matrix.below[at];
      full.block<3, 3>(3 * column, 3 * row) = matrix.below[at].transpose();
    }
  }
  return full;
}

Eigen::VectorXd stacked(const Blocks& blocks) {
  Eigen::VectorXd all(3 * static_cast<Eigen::Index>(blocks.size()));
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    all.segment<3>(3 * static_cast<Eigen::Index>(i)) = blocks[i];
  }
  return all;
}

Blocks random_blocks(std::size_t size, Rng& rng) {
  Blocks blocks;
  for (std::size_t i = 0; i < size; ++i)
    blocks.emplace_back(rng.normal(), rng.normal(), rng.normal());
  return blocks;
}

TEST(LinearisedGraph, GradientIsThatOfHalfTheCost) {
  PoseGraph graph = city();
  LinearisedGraph equations(graph);
  const GraphState state{graph.poses, graph.landmarks};
  EXPECT_NEAR(equations.linearise(state), graph_cost(graph), 1e-9 * graph_cost(graph));
  const Blocks gradient = equations.gradient();
  const double h = 1e-6;
  for (std::size_t place = 0; place < gradient.size(); ++place) {
    for (int axis = 0; axis < 3; ++axis) {
      Blocks step(gradient.size(), Eigen::Vector3d::Zero());
      const auto cost_at = [&](double length) {
        step[place](axis) = length;
        const GraphState moved = equations.moved(state, step);
        PoseGraph there = graph;
        there.poses = moved.poses;
        there.landmarks = moved.landmarks;
        return graph_cost(there);
      };
      const double slope = 0.5 * (cost_at(h) - cost_at(-h)) / (2.0 * h);
      EXPECT_NEAR(gradient[place](axis), slope, 1e-4 * (1.0 + std::abs(slope))) << place;
    }
  }
}

TEST(LinearisedGraph, HeldPosesAndUnseenLandmarksHaveNoPlace) {
  const PoseGraph graph = city();
  LinearisedGraph equations(graph);
  EXPECT_EQ(equations.place_of(NodeId{7}), -1);
  EXPECT_GE(equations.place_of(NodeId{0}), 0);
  EXPECT_GE(equations.place_of(LandmarkId{0}), 0);
  EXPECT_EQ(equations.place_of(LandmarkId{1}), -1);
  EXPECT_EQ(equations.gradient().size(), graph.poses.size() - 1 + 1);
  const Blocks step(equations.gradient().size(), Eigen::Vector3d(1.0, 2.0, 0.1));
  const GraphState moved = equations.moved({graph.poses, graph.landmarks}, step);
  EXPECT_EQ(moved.poses[7].x, graph.poses[7].x);
  EXPECT_EQ(moved.poses[0].x, graph.poses[0].x + 1.0);
  EXPECT_EQ(moved.landmarks[0].y(), graph.landmarks[0].y() + 2.0);
  EXPECT_EQ(moved.landmarks[1].y(), graph.landmarks[1].y());
}

TEST(LinearisedGraph, ItsStepsLeadToTheSolution) {
  const PoseGraph graph = city();
  LinearisedGraph equations(graph);
  BlockSolver solver(equations.hessian());
  GraphState state{graph.poses, graph.landmarks};
  for (int i = 0; i < 20; ++i) {
    equations.linearise(state);
    ASSERT_TRUE(solver.factorise(equations.hessian()));
    Blocks step = equations.gradient();
    for (Eigen::Vector3d& block : step) block = -block;
    solver.solve_in_place(step);
    state = equations.moved(state, step);
  }
  const SolveResult solved = optimize(graph);
  EXPECT_NEAR(equations.linearise(state), solved.cost, 1e-6 * solved.cost);
}

TEST(LinearisedGraph, AKernelSoftensClosures) {
  PoseGraph graph = city();
  const GraphState state{graph.poses, graph.landmarks};
  const double plain = LinearisedGraph(graph).linearise(state);
  EXPECT_LT(LinearisedGraph(graph, RobustKernel::kHuber, 0.1).linearise(state), plain);
  for (RelativePoseEdge& edge : graph.edges) edge.kind = EdgeKind::kOdometry;
  EXPECT_EQ(LinearisedGraph(graph, RobustKernel::kHuber, 0.1).linearise(state), plain);
}

TEST(LinearisedGraph, RefusesWhatCheckGraphRefuses) {
  PoseGraph graph = city();
  graph.edges[1].from.index = 1000;
  EXPECT_THROW((void)LinearisedGraph(graph), UsageError);
}

TEST(BlockSystem, ProductAndSolutionAreThoseOfTheDenseMatrix) {
  Rng rng(5);
  const PoseGraph graph = city();
  LinearisedGraph equations(graph);
  equations.linearise({graph.poses, graph.landmarks});
  const Eigen::MatrixXd full = dense(equations.hessian());
  const Blocks x = random_blocks(equations.gradient().size(), rng);
  Blocks product(x.size());
  multiply(equations.hessian(), x, product);
  EXPECT_LT((stacked(product) - full * stacked(x)).norm(), 1e-9 * stacked(product).norm());
  BlockSolver solver(equations.hessian());
  ASSERT_TRUE(solver.factorise(equations.hessian()));
  solver.solve_in_place(product);
  EXPECT_LT((stacked(product) - stacked(x)).norm(), 1e-6 * stacked(x).norm());
}

TEST(BlockSystem, SaysThatAMatrixIsNotPositiveDefinite) {
  BlockMatrix matrix = block_matrix(2, {{0, 1}});
  matrix.diagonal[0].setIdentity();
  matrix.diagonal[1].setIdentity();
  BlockSolver solver(matrix);
  EXPECT_TRUE(solver.factorise(matrix));
  matrix.below[0] = 2.0 * Eigen::Matrix3d::Identity();
  EXPECT_FALSE(solver.factorise(matrix));
}

}  // namespace
}  // namespace loopstone
