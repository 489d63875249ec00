#include "loopstone/graph/marginals.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "loopstone/base/error.hpp"
#include "loopstone/graph/solver.hpp"
#include "support/manhattan_graph.hpp"

namespace loopstone {
namespace {

/// From the definition, everything dense; the first pose fixed unless there is a prior.
Eigen::MatrixXd dense_covariance(const PoseGraph& graph) {
  const auto size = 3 * static_cast<Eigen::Index>(graph.poses.size());
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(size, size);
  for (const RelativePoseEdge& edge : graph.edges) {
    const EdgeJacobians j =
        edge_jacobians(edge, graph.poses[static_cast<std::size_t>(edge.from.index)],
                       graph.poses[static_cast<std::size_t>(edge.to.index)]);
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(3, size);
    jacobian.middleCols<3>(3 * edge.from.index) = j.from;
    jacobian.middleCols<3>(3 * edge.to.index) = j.to;
    h += jacobian.transpose() * edge.information * jacobian;
  }
  for (const PosePrior& prior : graph.priors) {
    const Eigen::Matrix3d j = prior_jacobian(prior);
    h.block<3, 3>(3 * prior.node.index, 3 * prior.node.index) +=
        j.transpose() * prior.information * j;
  }
  if (!graph.priors.empty()) return h.inverse();
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size, size);
  covariance.bottomRightCorner(size - 3, size - 3) =
      h.bottomRightCorner(size - 3, size - 3).inverse();
  return covariance;
}

void expect_dense(const PoseGraph& graph) {
  const Eigen::MatrixXd expected = dense_covariance(graph);
  const std::vector<NodeId> nodes{{0}, {7}, {39}, {7}};
  const PoseMarginals single = marginal_covariances(graph, nodes);
  ASSERT_TRUE(single.available);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const int n = 3 * nodes[i].index;
    EXPECT_LT((single.covariances[i] - expected.block<3, 3>(n, n)).norm(), 1e-9);
  }
  const std::vector<std::pair<NodeId, NodeId>> pairs{
      {{3}, {20}}, {{20}, {3}}, {{0}, {5}}, {{6}, {6}}};
  const PairMarginals joint = joint_covariances(graph, pairs);
  ASSERT_TRUE(joint.available);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const int a = 3 * pairs[i].first.index;
    const int b = 3 * pairs[i].second.index;
    Eigen::Matrix<double, 6, 6> dense;
    dense << expected.block<3, 3>(a, a), expected.block<3, 3>(a, b), expected.block<3, 3>(b, a),
        expected.block<3, 3>(b, b);
    EXPECT_LT((joint.covariances[i] - dense).norm(), 1e-9) << i;
  }
}

TEST(Marginals, EqualTheDenseInverse) {
  PoseGraph graph = test::manhattan_graph({.nodes = 40, .blocks = 2}, Rng(31)).graph;
  expect_dense(graph);
  graph.priors = {{{5}, {1.0, 2.0, 0.3}, 4.0 * Eigen::Matrix3d::Identity()}};
  expect_dense(graph);
}

TEST(Marginals, OfAChainAddUp) {
  PoseGraph graph;
  graph.poses = {{}, {1.0, 0.0, 0.0}, {2.0, 0.0, 0.0}};
  graph.edges = {{{0}, {1}, {1.0, 0.0, 0.0}, Eigen::Vector3d(4.0, 4.0, 100.0).asDiagonal()},
                 {{1}, {2}, {1.0, 0.0, 0.0}, Eigen::Vector3d(4.0, 4.0, 100.0).asDiagonal()}};
  const std::vector<NodeId> nodes{{0}, {2}};
  const PoseMarginals marginals = marginal_covariances(graph, nodes);
  EXPECT_EQ(marginals.covariances[0], Eigen::Matrix3d::Zero());
  EXPECT_NEAR(marginals.covariances[1](0, 0), 0.5, 1e-12);
  // A turn of the first step by 0.1 rad moves the end by 0.1 m.
  EXPECT_NEAR(marginals.covariances[1](1, 1), 0.5 + 0.01, 1e-12);
  EXPECT_NEAR(marginals.covariances[1](2, 2), 0.02, 1e-12);
  const std::vector<std::pair<NodeId, NodeId>> pair{{{1}, {2}}};
  const Eigen::Matrix3d relative = relative_covariance(
      graph.poses[1], graph.poses[2], joint_covariances(graph, pair).covariances.front());
  EXPECT_LT((relative - graph.edges[1].information.inverse()).norm(), 1e-12);
}

TEST(Marginals, RefuseNodesThatDoNotExist) {
  PoseGraph graph;
  graph.poses.resize(1);
  const std::vector<NodeId> nodes{{1}};
  EXPECT_THROW((void)marginal_covariances(graph, nodes), UsageError);
}

}  // namespace
}  // namespace loopstone
