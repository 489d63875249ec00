#include "loopstone/graph/marginals.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "loopstone/base/error.hpp"
#include "loopstone/graph/solver.hpp"
#include "support/manhattan_graph.hpp"

namespace loopstone {
namespace {

/// What the edges between poses tell, dense, in a system of so many unknowns.
Eigen::MatrixXd information_of_edges(const PoseGraph& graph, Eigen::Index size) {
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
  return h;
}

/// From the definition, everything dense; the first pose fixed unless there is a prior.
Eigen::MatrixXd dense_covariance(const PoseGraph& graph) {
  const auto size = 3 * static_cast<Eigen::Index>(graph.poses.size());
  Eigen::MatrixXd h = information_of_edges(graph, size);
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

/// Two landmarks seen from a chain of three poses.
PoseGraph chain_with_landmarks() {
  PoseGraph graph;
  graph.poses = {{}, {1.0, 0.1, 0.2}, {1.9, 0.5, 0.5}};
  for (int i = 0; i < 2; ++i) {
    const auto at = static_cast<std::size_t>(i);
    graph.edges.push_back({{i},
                           {i + 1},
                           graph.poses[at].inverse() * graph.poses[at + 1],
                           Eigen::Vector3d(400.0, 900.0, 2500.0).asDiagonal()});
  }
  graph.landmarks = {{2.0, 3.0}, {4.0, -1.0}};
  for (int pose = 0; pose < 3; ++pose) {
    for (int landmark = 0; landmark < 2; ++landmark) {
      Eigen::Matrix2d information;
      information << 100.0 + pose, 5.0, 5.0, 60.0 + landmark;
      graph.landmark_edges.push_back({{pose},
                                      {landmark},
                                      graph.poses[static_cast<std::size_t>(pose)].inverse() *
                                          graph.landmarks[static_cast<std::size_t>(landmark)],
                                      information});
    }
  }
  return graph;
}

/// Of the landmarks, all together; from the definition, with the first pose held.
Eigen::MatrixXd dense_landmark_covariance(const PoseGraph& graph) {
  const auto poses = 3 * static_cast<Eigen::Index>(graph.poses.size());
  const auto size = poses + 2 * static_cast<Eigen::Index>(graph.landmarks.size());
  Eigen::MatrixXd h = information_of_edges(graph, size);
  for (const LandmarkEdge& edge : graph.landmark_edges) {
    const LandmarkJacobians j =
        landmark_jacobians(graph.poses[static_cast<std::size_t>(edge.from.index)],
                           graph.landmarks[static_cast<std::size_t>(edge.landmark.index)]);
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(2, size);
    jacobian.middleCols<3>(3 * edge.from.index) = j.from;
    jacobian.middleCols<2>(poses + 2 * edge.landmark.index) = j.landmark;
    h += jacobian.transpose() * edge.information * jacobian;
  }
  const Eigen::MatrixXd free = h.bottomRightCorner(size - 3, size - 3).inverse();
  return free.bottomRightCorner(size - poses, size - poses);
}

TEST(Marginals, OfLandmarksEqualTheDenseInverse) {
  const PoseGraph graph = chain_with_landmarks();
  const Eigen::MatrixXd expected = dense_landmark_covariance(graph);
  EXPECT_LT((joint_landmark_covariance(graph) - expected).norm(), 1e-9);
  const std::vector<LandmarkId> both{{0}, {1}};
  const LandmarkMarginals marginals = landmark_covariances(graph, both);
  ASSERT_TRUE(marginals.available);
  for (int i = 0; i < 2; ++i) {
    EXPECT_LT(
        (marginals.covariances[static_cast<std::size_t>(i)] - expected.block<2, 2>(2 * i, 2 * i))
            .norm(),
        1e-9);
  }
}

TEST(Marginals, RefuseLandmarksThatNobodySees) {
  PoseGraph graph = chain_with_landmarks();
  graph.landmarks.emplace_back(1.0, 1.0);
  const std::vector<LandmarkId> unseen{{2}};
  const std::vector<LandmarkId> missing{{3}};
  EXPECT_THROW((void)landmark_covariances(graph, unseen), UsageError);
  EXPECT_THROW((void)landmark_covariances(graph, missing), UsageError);
  EXPECT_THROW((void)joint_landmark_covariance(graph), UsageError);
}

TEST(Marginals, RefuseNodesThatDoNotExist) {
  PoseGraph graph;
  graph.poses.resize(1);
  const std::vector<NodeId> nodes{{1}};
  EXPECT_THROW((void)marginal_covariances(graph, nodes), UsageError);
}

}  // namespace
}  // namespace loopstone
