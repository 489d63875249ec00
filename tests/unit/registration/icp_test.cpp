#include "loopstone/registration/icp.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>

#include "loopstone/base/error.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "support/generators.hpp"
#include "support/pose_near.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using Cloud = std::vector<Eigen::Vector2d>;
using test::pose_near;

constexpr IcpMetric kMetrics[] = {IcpMetric::kPoint, IcpMetric::kLine, IcpMetric::kPlane,
                                  IcpMetric::kGicp};

IcpOptions precise(IcpMetric metric) {
  IcpOptions options;
  options.metric = metric;
  options.max_iterations = 150;
  options.tolerance_m = 1e-10;
  options.tolerance_rad = 1e-10;
  return options;
}

Cloud transformed(const Pose2& target_T_source, const Cloud& source) {
  Cloud target;
  for (const Eigen::Vector2d& point : source) target.push_back(target_T_source * point);
  return target;
}

Cloud room_seen_from(const Pose2& world_T_robot, double noise_m = 0.0, Rng* rng = nullptr) {
  test::Scanner scanner;
  scanner.noise_m = noise_m;
  return scan_points(test::scan_from(test::furnished_room(), world_T_robot, Pose2{}, scanner, rng),
                     Pose2{});
}

/// Points every 5 cm along a segment.
Cloud along(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  Cloud points;
  const double length = (to - from).norm();
  for (double s = 0.0; s <= length; s += 0.05) points.push_back(from + (to - from) * (s / length));
  return points;
}

Cloud joined(Cloud a, const Cloud& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(Icp, CloudToItselfIsIdentity) {
  const Cloud cloud = room_seen_from({4.0, 3.0, 0.3});
  for (const IcpMetric metric : kMetrics) {
    const MatchResult result = match_icp(cloud, make_icp_cloud<2>(cloud), {}, precise(metric));
    EXPECT_EQ(result.status, MatchStatus::kConverged) << to_string(metric);
    // Fitted lines cut corners.
    const double tolerance = metric == IcpMetric::kPlane ? 5e-4 : 1e-12;
    EXPECT_TRUE(pose_near(result.target_T_source, {}, tolerance, tolerance)) << to_string(metric);
    EXPECT_NEAR(result.rmse_m, 0.0, 10.0 * tolerance);
    EXPECT_GT(result.score, 0.7);
  }
}

TEST(Icp, RecoversTheMotionOfTheSamePointsExactly) {
  const Cloud source = room_seen_from({4.0, 3.0, 0.3});
  const auto expect_found = [&](const Pose2& truth, const IcpMetric metric) {
    const MatchResult result =
        match_icp(source, make_icp_cloud<2>(transformed(truth, source)), {}, precise(metric));
    EXPECT_TRUE(pose_near(result.target_T_source, truth, 1e-7, 1e-7)) << to_string(metric);
    EXPECT_EQ(result.status, MatchStatus::kConverged) << to_string(metric);
  };
  expect_found({0.05, -0.03, 0.02}, IcpMetric::kLine);
  expect_found({-0.15, 0.1, -0.1}, IcpMetric::kLine);
  // Beams stand 0.5 deg apart: point to point also settles where every point has its neighbour's
  // partner.
  expect_found({0.02, -0.01, 0.003}, IcpMetric::kPoint);
}

TEST(Icp, FindsTheMotionBetweenTwoViews) {
  Rng rng(3);
  const Pose2 world_T_target{4.0, 3.0, 0.3};
  const Pose2 truth{0.2, 0.05, 0.15};
  const IcpCloud<2> target = make_icp_cloud<2>(room_seen_from(world_T_target, 0.01, &rng));
  const Cloud source = room_seen_from(world_T_target * truth, 0.01, &rng);
  for (const IcpMetric metric : kMetrics) {
    IcpOptions options;
    options.metric = metric;
    const MatchResult result = match_icp(source, target, {}, options);
    EXPECT_TRUE(pose_near(result.target_T_source, truth, 0.03, 0.01)) << to_string(metric);
    EXPECT_EQ(result.status, MatchStatus::kConverged);
    EXPECT_LT(std::sqrt(result.covariance(0, 0)), 0.02);
    EXPECT_GT(std::sqrt(result.covariance(0, 0)), 1e-5);
  }
}

RC_GTEST_PROP(Icp, DoesNotDependOnWhereBothCloudsLie, ()) {
  const Pose2 moved_T_target = *test::any_pose2();
  const Pose2 target_T_source{0.1, -0.05, 0.05};
  const Cloud target = room_seen_from({4.0, 3.0, 0.3});
  const Cloud source = room_seen_from(Pose2{4.0, 3.0, 0.3} * target_T_source);
  for (const IcpMetric metric : kMetrics) {
    const MatchResult here = match_icp(source, make_icp_cloud<2>(target), {}, precise(metric));
    const MatchResult there =
        match_icp(source, make_icp_cloud<2>(transformed(moved_T_target, target)), moved_T_target,
                  precise(metric));
    // Rounding may pair a point that lies between two others differently.
    RC_ASSERT(pose_near(there.target_T_source, moved_T_target * here.target_T_source, 1e-3, 1e-3));
  }
}

RC_GTEST_PROP(Icp, RecoversAnySmallMotionOfTheSamePoints, ()) {
  const Pose2 truth{*test::between(-0.1, 0.1), *test::between(-0.1, 0.1),
                    *test::between(-0.1, 0.1)};
  const Cloud source = room_seen_from({2.0, 2.0, 1.0});
  const MatchResult result = match_icp(source, make_icp_cloud<2>(transformed(truth, source)), {},
                                       precise(IcpMetric::kLine));
  RC_ASSERT(pose_near(result.target_T_source, truth, 1e-6, 1e-6));
}

TEST(Icp, KeepsTheGuessAlongACorridor) {
  const Cloud walls = joined(along({-10.0, 1.0}, {10.0, 1.0}), along({-10.0, -1.0}, {10.0, -1.0}));
  const Pose2 guess{0.13, 0.1, 0.05};  // 13 cm along the corridor is what odometry says
  for (const IcpMetric metric : kMetrics) {
    const MatchResult result = match_icp(walls, make_icp_cloud<2>(walls), guess, precise(metric));
    EXPECT_EQ(result.status, MatchStatus::kDegenerate) << to_string(metric);
    EXPECT_TRUE(pose_near(result.target_T_source, {0.13, 0.0, 0.0}, 0.02, 1e-3))
        << to_string(metric);
    EXPECT_GT(result.covariance(0, 0), 1.0);
    EXPECT_LT(result.covariance(1, 1), 1e-3);
    EXPECT_LT(result.covariance(2, 2), 1e-3);
  }
}

TEST(Icp, KnowsThatATurnInsideACircleIsUnobserved) {
  Cloud circle;
  const Eigen::Vector2d centre(1.0, 2.0);
  for (int degree = 0; degree < 360; ++degree) {
    circle.emplace_back(
        centre + 3.0 * Eigen::Vector2d(std::cos(radians(degree)), std::sin(radians(degree))));
  }
  const MatchResult result = match_icp(circle, make_icp_cloud<2>(circle), {0.05, 0.02, 0.03}, {});
  EXPECT_EQ(result.status, MatchStatus::kDegenerate);
  EXPECT_GT(result.covariance(2, 2), 0.1);
  // The centre is where it was, whatever the heading.
  EXPECT_LT((result.target_T_source * centre - centre).norm(), 5e-3);
}

TEST(Icp, KnowsThatASingleWallLeavesADirectionOpen) {
  const Cloud wall = along({-3.0, 2.0}, {3.0, 2.0});
  for (const IcpMetric metric : kMetrics) {
    const MatchResult result =
        match_icp(wall, make_icp_cloud<2>(wall), {0.3, 0.1, 0.02}, precise(metric));
    EXPECT_EQ(result.status, MatchStatus::kDegenerate) << to_string(metric);
    EXPECT_GT(result.covariance(0, 0), 1.0);
    // The middle of the wall stays where the guess has it along the wall, and moves onto it.
    const Eigen::Vector2d middle(0.0, 2.0);
    EXPECT_NEAR((result.target_T_source * middle).x(), (Pose2{0.3, 0.1, 0.02} * middle).x(), 0.01);
    EXPECT_NEAR((result.target_T_source * middle).y(), 2.0, 0.01);
  }
}

TEST(Icp, CovarianceShrinksWithThePointsAndHoldsTheError) {
  // Over many draws the error, in units of what the covariance promises, is neither tiny nor huge.
  Rng rng(8);
  const Pose2 world_T_target{4.0, 3.0, 0.3};
  const Pose2 truth{0.1, 0.0, 0.05};
  double squared_sum = 0.0;
  constexpr int kDraws = 30;
  for (int draw = 0; draw < kDraws; ++draw) {
    const IcpCloud<2> target = make_icp_cloud<2>(room_seen_from(world_T_target, 0.02, &rng));
    const Cloud source = room_seen_from(world_T_target * truth, 0.02, &rng);
    const MatchResult result = match_icp(source, target, {}, {});
    const Eigen::Vector2d error = result.target_T_source.translation() - truth.translation();
    squared_sum += error.squaredNorm() / result.covariance.topLeftCorner<2, 2>().trace();
  }
  EXPECT_GT(std::sqrt(squared_sum / kDraws), 0.2);
  EXPECT_LT(std::sqrt(squared_sum / kDraws), 5.0);
}

TEST(Icp, IsNotMovedByAFewStrangers) {
  Rng rng(9);
  Cloud source = room_seen_from({4.0, 3.0, 0.3});
  const Pose2 truth{0.1, -0.05, 0.05};
  const IcpCloud<2> target = make_icp_cloud<2>(transformed(truth, source));
  for (std::size_t i = 0; i < source.size(); i += 20) {
    source[i] += Eigen::Vector2d(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0));
  }
  const MatchResult result = match_icp(source, target, {}, precise(IcpMetric::kLine));
  EXPECT_TRUE(pose_near(result.target_T_source, truth, 2e-3, 1e-3));
}

TEST(Icp, SaysWhenThereIsTooLittleAndReturnsTheGuess) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const Pose2 guess{1.0, 2.0, 3.0};
  const Cloud cloud = room_seen_from({4.0, 3.0, 0.3});
  const Cloud nothing;
  const Cloud bad(10, Eigen::Vector2d(kNan, 1.0));
  for (const IcpMetric metric : kMetrics) {
    for (const Cloud& source : {nothing, bad, Cloud{{0.0, 0.0}, {1.0, 1.0}}}) {
      const MatchResult result =
          match_icp(source, make_icp_cloud<2>(cloud), guess, precise(metric));
      EXPECT_EQ(result.status, MatchStatus::kTooFewPairs);
      EXPECT_EQ(result.target_T_source, guess);
    }
    for (const Cloud& target : {nothing, bad}) {
      const MatchResult result =
          match_icp(cloud, make_icp_cloud<2>(target), guess, precise(metric));
      EXPECT_EQ(result.status, MatchStatus::kTooFewPairs);
      EXPECT_EQ(result.target_T_source, guess);
    }
    const Pose2 far_away{100.0, 0.0, 0.0};
    EXPECT_EQ(match_icp(cloud, make_icp_cloud<2>(cloud), far_away, precise(metric)).status,
              MatchStatus::kTooFewPairs);
  }
}

TEST(Icp, ManyPointsInOnePlaceDoNotCrash) {
  const Cloud heap(50, Eigen::Vector2d(1.0, 1.0));
  for (const IcpMetric metric : kMetrics) {
    const MatchResult result = match_icp(heap, make_icp_cloud<2>(heap), {}, precise(metric));
    EXPECT_NE(result.status, MatchStatus::kConverged) << to_string(metric);
    EXPECT_FALSE(result.covariance.hasNaN());
    EXPECT_TRUE(result.target_T_source.vector().allFinite());
  }
}

TEST(Icp, SaysWhenTheIterationsRanOut) {
  const Cloud cloud = room_seen_from({4.0, 3.0, 0.3});
  IcpOptions options = precise(IcpMetric::kPoint);
  options.max_iterations = 1;
  const MatchResult result = match_icp(cloud, make_icp_cloud<2>(cloud), {0.2, 0.2, 0.1}, options);
  EXPECT_EQ(result.status, MatchStatus::kNotConverged);
  EXPECT_EQ(result.iterations, 1);
}

TEST(Icp, RefusesAnUnknownMetric) {}

}  // namespace
}  // namespace loopstone
