#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/registration/icp.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "support/generators.hpp"
#include "support/pose_near.hpp"
#include "support/segment_world.hpp"

// What must hold for every alignment by iterated closest points, in the plane and in space.
namespace loopstone {
namespace {

using Planar = std::vector<Eigen::Vector2d>;
using Spatial = std::vector<Eigen::Vector3d>;
using test::pose_near;

constexpr IcpMetric kMetrics[] = {IcpMetric::kPoint, IcpMetric::kLine, IcpMetric::kPlane,
                                  IcpMetric::kGicp};

IcpOptions with_metric(IcpMetric metric) {
  IcpOptions options;
  options.metric = metric;
  options.max_pair_distance_m = 0.5;
  options.max_iterations = 100;
  return options;
}

Planar room_seen_from(const Pose2& world_T_robot, double noise_m = 0.0, Rng* rng = nullptr) {
  test::Scanner scanner;
  scanner.beams = 271;
  scanner.angle_increment_rad *= 2.0;
  scanner.noise_m = noise_m;
  return scan_points(test::scan_from(test::furnished_room(), world_T_robot, Pose2{}, scanner, rng),
                     Pose2{});
}

template <typename Pose, typename Points>
Points moved(const Pose& pose, const Points& points) {
  Points result;
  for (const auto& point : points) result.push_back(pose * point);
  return result;
}

template <typename Points>
void shuffle(Points& points, Rng& rng) {
  for (std::size_t i = points.size(); i > 1; --i) std::swap(points[i - 1], points[rng.below(i)]);
}

/// The walls of a room, some layers above and below the plane z = 0.
Spatial extruded(const Planar& points) {
  Spatial result;
  for (const double z : {-0.1, -0.05, 0.0, 0.05, 0.1}) {
    for (const auto& point : points) result.emplace_back(point.x(), point.y(), z);
  }
  return result;
}

const Pose2 kWorld_T_target{4.0, 3.0, 0.3};
const Pose2 kTruth{0.12, -0.06, 0.08};

RC_GTEST_PROP(IcpLaws, ACommonMotionOfTheTargetMovesTheResult, ()) {
  const Pose2 moved_T_target = *test::any_pose2();
  const Planar target = room_seen_from(kWorld_T_target);
  const Planar source = room_seen_from(kWorld_T_target * kTruth);
  for (const IcpMetric metric : kMetrics) {
    const MatchResult here = match_icp(source, make_icp_cloud<2>(target), {}, with_metric(metric));
    const MatchResult there = match_icp(source, make_icp_cloud<2>(moved(moved_T_target, target)),
                                        moved_T_target, with_metric(metric));
    // Rounding may pair a point that lies between two others differently.
    RC_ASSERT(pose_near(there.target_T_source, moved_T_target * here.target_T_source, 1e-3, 1e-3));
    RC_ASSERT(there.status == here.status);
  }
}

RC_GTEST_PROP(IcpLaws, AnotherFrameOfTheSourceIsTakenOffTheResult, ()) {
  // Not far: steps are judged about the source's origin and its points.
  const Pose2 source_T_other{*test::between(-2.0, 2.0), *test::between(-2.0, 2.0),
                             *test::any_angle()};
  const auto target = make_icp_cloud<2>(room_seen_from(kWorld_T_target));
  const Planar source = room_seen_from(kWorld_T_target * kTruth);
  for (const IcpMetric metric : kMetrics) {
    const MatchResult here = match_icp(source, target, {}, with_metric(metric));
    const MatchResult other = match_icp(moved(source_T_other.inverse(), source), target,
                                        source_T_other, with_metric(metric));
    RC_ASSERT(pose_near(other.target_T_source, here.target_T_source * source_T_other, 3e-3, 1e-3));
  }
}

TEST(IcpLaws, TheOrderOfThePointsDoesNotMatter) {
  Rng rng(81);
  const Planar target = room_seen_from(kWorld_T_target, 0.01, &rng);
  const Planar source = room_seen_from(kWorld_T_target * kTruth, 0.01, &rng);
  for (const IcpMetric metric : kMetrics) {
    const MatchResult first = match_icp(source, make_icp_cloud<2>(target), {}, with_metric(metric));
    for (int draw = 0; draw < 5; ++draw) {
      Planar shuffled_target = target;
      Planar shuffled_source = source;
      shuffle(shuffled_target, rng);
      shuffle(shuffled_source, rng);
      const MatchResult again =
          match_icp(shuffled_source, make_icp_cloud<2>(shuffled_target), {}, with_metric(metric));
      EXPECT_TRUE(pose_near(again.target_T_source, first.target_T_source, 1e-9, 1e-9))
          << to_string(metric);
      EXPECT_EQ(again.pairs, first.pairs) << to_string(metric);
      EXPECT_TRUE(again.covariance.isApprox(first.covariance, 1e-6)) << to_string(metric);
    }
  }
}

TEST(IcpLaws, AllWaysToTheNearestPointGiveTheSameResult) {
  Rng rng(82);
  const Planar target = room_seen_from(kWorld_T_target, 0.01, &rng);
  const Planar source = room_seen_from(kWorld_T_target * kTruth, 0.01, &rng);
  for (const IcpMetric metric : kMetrics) {
    const MatchResult by_tree =
        match_icp(source, make_icp_cloud<2>(target), {}, with_metric(metric));
    for (const PointSearch search : {PointSearch::kGrid, PointSearch::kProjection}) {
      IcpCloudOptions<2> options;
      options.search = search;
      const MatchResult result =
          match_icp(source, make_icp_cloud<2>(target, options), {}, with_metric(metric));
      EXPECT_EQ(result.target_T_source, by_tree.target_T_source)
          << to_string(metric) << " " << to_string(search);
      EXPECT_EQ(result.covariance, by_tree.covariance)
          << to_string(metric) << " " << to_string(search);
    }
  }
}

RC_GTEST_PROP(IcpLaws, ScalesWithTheUnitOfLength, ()) {
  const double scale = *rc::gen::element(0.01, 0.3, 20.0);
  const Planar target = room_seen_from(kWorld_T_target);
  const Planar source = room_seen_from(kWorld_T_target * kTruth);
  const auto scaled = [scale](Planar points) {
    for (auto& point : points) point *= scale;
    return points;
  };
  IcpCloudOptions<2> cloud;
  cloud.patches.dense_radius_m *= scale;
  cloud.patches.reach_m *= scale;
  for (const IcpMetric metric : kMetrics) {
    const MatchResult one = match_icp(source, make_icp_cloud<2>(target), {}, with_metric(metric));
    IcpOptions options = with_metric(metric);
    options.max_pair_distance_m *= scale;
    options.final_pair_distance_m *= scale;
    options.kernel_width_m *= scale;
    options.tolerance_m *= scale;
    options.point_sigma_m *= scale;
    const MatchResult other = match_icp(make_icp_cloud<2>(scaled(source), cloud),
                                        make_icp_cloud<2>(scaled(target), cloud), {}, options);
    const Pose2 expected{scale * one.target_T_source.x, scale * one.target_T_source.y,
                         one.target_T_source.yaw};
    RC_ASSERT(pose_near(other.target_T_source, expected, 1e-3 * scale, 1e-3));
    RC_ASSERT(std::abs(other.score - one.score) < 0.02);
  }
}

TEST(IcpLaws, SpaceAgreesWithThePlaneOnWalls) {
  Rng rng(83);
  const Planar target = room_seen_from(kWorld_T_target, 0.0, &rng);
  const Planar source = room_seen_from(kWorld_T_target * kTruth, 0.0, &rng);
  PatchOptions<2> planar;
  planar.smooth = false;
  planar.dense_radius_m = 0.0;
  for (const IcpMetric metric : {IcpMetric::kPoint, IcpMetric::kPlane, IcpMetric::kGicp}) {
    const MatchResult in_plane =
        match_icp(source, make_icp_cloud<2>(target, {.patches = planar}), {}, with_metric(metric));
    const MatchResult3 in_space =
        match_icp(extruded(source), make_icp_cloud<3>(extruded(target)), {}, with_metric(metric));
    // Normals come from other neighbours, so they differ at corners. What walls can't tell, the
    // height, stays.
    EXPECT_TRUE(pose_near(in_space.target_T_source, Pose3::from_pose2(in_plane.target_T_source),
                          5e-3, 2e-3))
        << to_string(metric);
    EXPECT_NEAR(in_space.target_T_source.translation.z(), 0.0, 1e-4) << to_string(metric);
    EXPECT_EQ(in_space.status, MatchStatus::kDegenerate) << to_string(metric);
  }
}

TEST(IcpLaws, SwappingSourceAndTargetGivesTheInverse) {
  Rng rng(84);
  for (int draw = 0; draw < 5; ++draw) {
    const Planar target = room_seen_from(kWorld_T_target, 0.005, &rng);
    const Planar source = room_seen_from(kWorld_T_target * kTruth, 0.005, &rng);
    for (const IcpMetric metric : {IcpMetric::kLine, IcpMetric::kPlane, IcpMetric::kGicp}) {
      const MatchResult there =
          match_icp(source, make_icp_cloud<2>(target), {}, with_metric(metric));
      const MatchResult back =
          match_icp(target, make_icp_cloud<2>(source), {}, with_metric(metric));
      EXPECT_TRUE(pose_near(back.target_T_source, there.target_T_source.inverse(), 6e-3, 3e-3))
          << to_string(metric);
    }
  }
}

/// Mean of e^T C^-1 e over random pairs of scans: 3 if the covariance tells the truth.
double mean_nees(IcpMetric metric, int draws) {
  Rng rng(85);
  double sum = 0.0;
  for (int draw = 0; draw < draws; ++draw) {
    const Pose2 world_T_target{rng.uniform(2.7, 6.0), rng.uniform(1.0, 4.0),
                               rng.uniform(-kPi, kPi)};
    const Pose2 truth{rng.uniform(-0.15, 0.15), rng.uniform(-0.15, 0.15), rng.uniform(-0.15, 0.15)};
    const auto target = make_icp_cloud<2>(room_seen_from(world_T_target, 0.01, &rng));
    const Planar source = room_seen_from(world_T_target * truth, 0.01, &rng);
    const MatchResult result = match_icp(source, target, {}, with_metric(metric));
    const Eigen::Vector3d error = RigidMotion<2>::difference(result.target_T_source, truth);
    sum += std::min(error.dot(result.covariance.ldlt().solve(error)), 100.0);
  }
  return sum / draws;
}

TEST(IcpLaws, TheCovarianceTellsTheErrors) {
  for (const IcpMetric metric : {IcpMetric::kLine, IcpMetric::kPlane, IcpMetric::kGicp}) {
    const double nees = mean_nees(metric, 200);
    EXPECT_GT(nees, 1.5) << to_string(metric);
    EXPECT_LT(nees, 6.0) << to_string(metric);
  }
}

TEST(IcpLaws, AWrongMinimumIsNotCalledConverged) {
  // Started anywhere, ICP ends anywhere; nearly all ends that are wrong must be called so, and
  // those that are right good.
  Rng rng(86);
  const auto target = make_icp_cloud<2>(room_seen_from(kWorld_T_target, 0.01, &rng));
  const Planar source = room_seen_from(kWorld_T_target * kTruth, 0.01, &rng);
  for (const IcpMetric metric : {IcpMetric::kLine, IcpMetric::kPlane, IcpMetric::kGicp}) {
    IcpOptions options;
    options.metric = metric;
    int wrong = 0;
    int believed = 0;
    for (int draw = 0; draw < 60; ++draw) {
      const Pose2 guess{rng.uniform(-2.0, 2.0), rng.uniform(-2.0, 2.0), rng.uniform(-kPi, kPi)};
      const MatchResult result = match_icp(source, target, guess, options);
      if (pose_near(result.target_T_source, kTruth, 0.05, 0.02)) {
        EXPECT_EQ(result.status, MatchStatus::kConverged) << to_string(metric);
        continue;
      }
      ++wrong;
      if (result.status == MatchStatus::kConverged) ++believed;
    }
    EXPECT_GT(wrong, 10) << to_string(metric);
    EXPECT_LE(believed, wrong / 10) << to_string(metric);
  }
}

}  // namespace
}  // namespace loopstone
