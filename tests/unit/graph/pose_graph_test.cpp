#include "loopstone/graph/pose_graph.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

std::vector<Pose2> interesting_poses() {
  std::vector<Pose2> poses{
      {}, {1e-9, -1e-9, 1e-9}, {0.3, -0.2, kPi}, {-2.0, 5.0, -kPi + 1e-3}, {1.0, 2.0, 0.5 * kPi}};
  Rng rng(7);
  for (int i = 0; i < 10; ++i) {
    poses.push_back({rng.uniform(-50.0, 50.0), rng.uniform(-50.0, 50.0), rng.uniform(-kPi, kPi)});
  }
  return poses;
}

Eigen::Vector3d difference(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return {a.x() - b.x(), a.y() - b.y(), wrap_angle(a.z() - b.z())};
}

Pose2 nudged(Pose2 pose, int coordinate, double by) {
  if (coordinate == 0) pose.x += by;
  if (coordinate == 1) pose.y += by;
  if (coordinate == 2) pose.yaw = wrap_angle(pose.yaw + by);
  return pose;
}

TEST(EdgeError, IsZeroForAPerfectMeasurement) {
  for (const Pose2& from : interesting_poses()) {
    for (const Pose2& to : interesting_poses()) {
      const RelativePoseEdge edge{{0}, {1}, from.inverse() * to};
      EXPECT_LT(edge_error(edge, from, to).norm(), 1e-12);
    }
  }
}

TEST(EdgeError, IsRotatedToTheMeasuredAxes) {
  const RelativePoseEdge edge{{0}, {1}, {1.0, 0.0, 0.5 * kPi}};
  // The second pose is 0.1 m too far along the first one's x axis, which is the measured pose's -y
  // axis.
  const Eigen::Vector3d error = edge_error(edge, {}, {1.1, 0.0, 0.5 * kPi});
  EXPECT_NEAR(error.x(), 0.0, 1e-15);
  EXPECT_NEAR(error.y(), -0.1, 1e-15);
}

TEST(EdgeJacobians, EqualNumericDerivatives) {
  constexpr double kStep = 1e-6;
  const auto poses = interesting_poses();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    for (std::size_t j = 0; j < poses.size(); ++j) {
      const Pose2& from = poses[i];
      const Pose2& to = poses[j];
      const RelativePoseEdge edge{{0}, {1}, poses[(3 * i + 5 * j + 1) % poses.size()]};
      const EdgeJacobians analytic = edge_jacobians(edge, from, to);
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d numeric_from =
            difference(edge_error(edge, nudged(from, k, kStep), to),
                       edge_error(edge, nudged(from, k, -kStep), to)) /
            (2.0 * kStep);
        const Eigen::Vector3d numeric_to =
            difference(edge_error(edge, from, nudged(to, k, kStep)),
                       edge_error(edge, from, nudged(to, k, -kStep))) /
            (2.0 * kStep);
        EXPECT_LT((analytic.from.col(k) - numeric_from).norm(), 1e-6) << i << ' ' << j << ' ' << k;
        EXPECT_LT((analytic.to.col(k) - numeric_to).norm(), 1e-6) << i << ' ' << j << ' ' << k;
      }
    }
  }
}

TEST(GraphCost, SumsSquaredErrorsWithoutHalf) {
  PoseGraph graph;
  graph.poses = {{}, {1.0, 0.0, 0.0}};
  graph.edges = {{{0}, {1}, {1.5, 0.0, 0.0}, 2.0 * Eigen::Matrix3d::Identity()},
                 {{0}, {1}, {1.0, 1.0, 0.0}}};
  EXPECT_DOUBLE_EQ(graph_cost(graph), 2.0 * 0.25 + 1.0);
}

std::string complaint_about(const RelativePoseEdge& edge) {
  PoseGraph graph;
  graph.poses.resize(3);
  graph.edges = {{{0}, {1}, {}}, edge};
  try {
    check_graph(graph);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(CheckGraph, NamesTheEdgeAndWhatIsWrong) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  using ::testing::HasSubstr;
  EXPECT_EQ(complaint_about({{1}, {2}, {}}), "");
  EXPECT_THAT(complaint_about({{1}, {3}, {}}), HasSubstr("edge 1 (1 -> 3)"));
  EXPECT_THAT(complaint_about({{-1}, {2}, {}}), HasSubstr("does not exist"));
  EXPECT_THAT(complaint_about({{2}, {2}, {}}), HasSubstr("itself"));
  EXPECT_THAT(complaint_about({{1}, {2}, {kNan, 0.0, 0.0}}), HasSubstr("measurement"));
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
  information(2, 2) = 0.0;
  EXPECT_THAT(complaint_about({{1}, {2}, {}, information}), HasSubstr("positive definite"));
  information(2, 2) = -1.0;
  EXPECT_THAT(complaint_about({{1}, {2}, {}, information}), HasSubstr("positive definite"));
  information(2, 2) = kNan;
  EXPECT_THAT(complaint_about({{1}, {2}, {}, information}), HasSubstr("finite"));
  information << 1.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0;
  EXPECT_THAT(complaint_about({{1}, {2}, {}, information}), HasSubstr("symmetric"));
}

TEST(CheckGraph, RefusesPosesThatAreNotFinite) {
  PoseGraph graph;
  graph.poses = {{}, {std::numeric_limits<double>::infinity(), 0.0, 0.0}};
  EXPECT_THROW(check_graph(graph), UsageError);
}

TEST(ConnectedComponents, AreNumberedByTheirLowestNode) {
  PoseGraph graph;
  graph.poses.resize(7);
  graph.edges = {{{5}, {0}, {}}, {{2}, {3}, {}}, {{6}, {3}, {}}, {{5}, {4}, {}}};
  const GraphComponents components = connected_components(graph);
  EXPECT_EQ(components.count, 3);
  EXPECT_THAT(components.of_node, ::testing::ElementsAre(0, 1, 2, 2, 0, 0, 2));
}

TEST(ConnectedComponents, OfNothing) { EXPECT_EQ(connected_components({}).count, 0); }

}  // namespace
}  // namespace loopstone
