#include "loopstone/slam/pose_covariances.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/graph/marginals.hpp"
#include "loopstone/slam/surface_adjustment.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

constexpr double kStepM = 0.02;
constexpr double kStepRad = 0.004;
constexpr int kKeysPerSegment = 12;

void join(PoseGraph& graph, int from, int to, EdgeKind kind, double sigma_m, double sigma_rad) {
  const Eigen::Vector3d sigma(sigma_m, sigma_m, sigma_rad);
  graph.edges.push_back({NodeId{from}, NodeId{to},
                         graph.poses[static_cast<std::size_t>(from)].inverse() *
                             graph.poses[static_cast<std::size_t>(to)],
                         sigma.cwiseAbs2().cwiseInverse().asDiagonal(), kind});
}

/// A wide arc, steps of 0.3 m.
PoseGraph arc(int count) {
  PoseGraph graph;
  for (int i = 0; i < count; ++i) {
    graph.poses.push_back(i == 0 ? Pose2{} : graph.poses.back() * Pose2{0.3, 0.0, 0.02});
    if (i > 0) join(graph, i - 1, i, EdgeKind::kOdometry, kStepM, kStepRad);
  }
  return graph;
}

Eigen::Matrix3d exact(const PoseGraph& graph, int from, int to) {
  const std::vector<std::pair<NodeId, NodeId>> pair{{NodeId{from}, NodeId{to}}};
  return relative_covariance(graph.poses[static_cast<std::size_t>(from)],
                             graph.poses[static_cast<std::size_t>(to)],
                             joint_covariances(graph, pair).covariances[0]);
}

/// How many times the variance of one is that of the other, at most and at least, in any direction.
std::pair<double, double> ratios(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix3d> solver(a, b);
  return {solver.eigenvalues()[0], solver.eigenvalues()[2]};
}

TEST(PoseCovariances, WithoutPosesThereIsNothingToKnow) {
  EXPECT_FALSE(PoseCovariances().available());
  EXPECT_FALSE(PoseCovariances(PoseGraph{}).available());
}

TEST(PoseCovariances, OfAPathAreThoseOfItsCompoundedMotions) {
  const PoseGraph graph = arc(121);
  const PoseCovariances covariances(graph);
  ASSERT_TRUE(covariances.available());
  EXPECT_TRUE(covariances.of(NodeId{0}).isZero());
  for (const auto& [from, to] : std::vector<std::pair<int, int>>{{6, 54}, {30, 114}, {18, 42}}) {
    const auto [least, most] =
        ratios(covariances.between(NodeId{from}, NodeId{to}), exact(graph, from, to));
    EXPECT_GT(least, 0.85) << from << " to " << to;
    EXPECT_LT(most, 1.3) << from << " to " << to;
  }
  const auto [least, most] =
      ratios(covariances.of(NodeId{114}),
             marginal_covariances(graph, std::vector{NodeId{114}}).covariances[0]);
  EXPECT_GT(least, 0.85);
  EXPECT_LT(most, 1.3);
}

TEST(PoseCovariances, ALoopClosureHoldsBothOfItsEnds) {
  const PoseGraph open = arc(121);
  PoseGraph closed = open;
  join(closed, 6, 114, EdgeKind::kLoopClosure, 0.02, 0.002);
  const Eigen::Matrix3d before = PoseCovariances(open).between(NodeId{6}, NodeId{114});
  const Eigen::Matrix3d after = PoseCovariances(closed).between(NodeId{6}, NodeId{114});
  EXPECT_LT(after(0, 0), 0.1 * before(0, 0));
  EXPECT_LT(after(1, 1), 0.1 * before(1, 1));
  EXPECT_LT(after(2, 2), 0.1 * before(2, 2));
  const auto [least, most] =
      ratios(PoseCovariances(closed).between(NodeId{6}, NodeId{54}), exact(closed, 6, 54));
  EXPECT_GT(least, 0.8) << "half of the way round";
  EXPECT_LT(most, 1.5) << "half of the way round";
}

TEST(PoseCovariances, BothWaysSayTheSame) {
  const PoseGraph graph = arc(60);
  const PoseCovariances covariances(graph);
  const Eigen::Matrix3d there = covariances.between(NodeId{20}, NodeId{50});
  const Eigen::Matrix3d back = covariances.between(NodeId{50}, NodeId{20});
  EXPECT_NEAR(there(2, 2), back(2, 2), 1e-12);
  EXPECT_NEAR(there.determinant(), back.determinant(), 1e-3 * there.determinant());
}

TEST(PoseCovariances, AMapIsAsLargeAsTheRangesSay) {
  PoseGraph graph;
  for (int i = 0; i < 2 * kKeysPerSegment; ++i) {
    graph.poses.push_back({10.0 * i, 0.0, 0.0});
    if (i > 0) join(graph, i - 1, i, EdgeKind::kOdometry, 1e-4, 1e-6);
  }
  const PoseCovariances covariances(graph);
  const Eigen::Matrix3d far = covariances.between(NodeId{0}, NodeId{20});
  EXPECT_GT(std::sqrt(far(0, 0)), 0.0005 * 200.0) << "no ranges are that true";
  EXPECT_LT(std::sqrt(far(1, 1)), 0.01) << "scale says nothing of what lies across";
}

TEST(PoseCovariances, SurfacesThatAreSharedHoldWhatTheyShow) {
  const test::Walls walls = test::furnished_room();
  const std::vector<Pose2> truth =
      test::drive_through({{1.5, 1.2}, {5.0, 1.5}, {5.2, 3.6}, {3.4, 4.4}, {1.5, 1.2}}, 0.2, 0.3);
  std::vector<std::vector<SurfacePoint>> surfaces;
  PoseGraph graph;
  Rng rng(3);
  BeamTable beams;
  test::Scanner scanner;
  scanner.noise_m = 0.01;
  for (const Pose2& pose : truth) {
    const LaserScan scan = test::scan_from(walls, pose, {}, scanner, &rng);
    surfaces.push_back(surface_points(scan, {}, Tangent2::Zero(), {.points_max = 120}, beams));
    graph.poses.push_back(pose);
    const auto i = static_cast<int>(graph.poses.size()) - 1;
    if (i > 0) join(graph, i - 1, i, EdgeKind::kOdometry, kStepM, kStepRad);
  }
  const SurfaceAdjustment adjusted = adjust_to_surfaces(graph, surfaces);
  const PoseCovariances alone(graph);
  ASSERT_TRUE(adjusted.covariances.available());
  double normalised = 0.0;
  int count = 0;
  for (int i = 20; i < static_cast<int>(truth.size()); i += 10) {
    const Eigen::Matrix3d covariance = adjusted.covariances.between(NodeId{0}, NodeId{i});
    EXPECT_LT(covariance.trace(), 0.25 * alone.between(NodeId{0}, NodeId{i}).trace());
    const Pose2 told =
        adjusted.poses.front().inverse() * adjusted.poses[static_cast<std::size_t>(i)];
    const Pose2 real = truth.front().inverse() * truth[static_cast<std::size_t>(i)];
    const Eigen::Vector3d error(told.x - real.x, told.y - real.y, told.yaw - real.yaw);
    normalised += error.dot(covariance.inverse() * error) / 3.0;
    ++count;
  }
  ASSERT_GT(count, 3);
  EXPECT_LT(normalised / count, 2.0) << "overconfident";
  EXPECT_GT(normalised / count, 0.005) << "says nothing";
}

}  // namespace
}  // namespace loopstone
