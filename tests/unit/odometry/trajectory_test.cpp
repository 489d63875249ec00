#include "loopstone/odometry/trajectory.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "support/generators.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::pose_near;

TEST(Trajectory, EmptyKnowsNothing) {
  const Trajectory none;
  EXPECT_TRUE(none.empty());
  EXPECT_FALSE(none.at({0}).has_value());
  EXPECT_FALSE(none.at_clamped({0}).has_value());
  EXPECT_FALSE(none.nearest({0}, {1'000'000'000}).has_value());
  EXPECT_EQ(none.path_length_m(), 0.0);
}

TEST(Trajectory, SortsAndKeepsTheLastOfEqualStamps) {
  const Trajectory path({{{30}, {3.0, 0.0, 0.0}},
                         {{10}, {1.0, 0.0, 0.0}},
                         {{20}, {2.0, 0.0, 0.0}},
                         {{10}, {9.0, 0.0, 0.0}}});
  ASSERT_EQ(path.size(), 3U);
  EXPECT_EQ(path.front().pose.x, 9.0);
  EXPECT_EQ(path.poses()[1].stamp, Stamp{20});
  EXPECT_EQ(path.back().stamp, Stamp{30});
}

TEST(Trajectory, AppendRefusesThePastAndReplacesThePresent) {
  Trajectory path;
  EXPECT_TRUE(path.append({10}, {1.0, 0.0, 0.0}));
  EXPECT_TRUE(path.append({20}, {2.0, 0.0, 0.0}));
  EXPECT_FALSE(path.append({15}, {5.0, 0.0, 0.0}));
  EXPECT_TRUE(path.append({20}, {7.0, 0.0, 0.0}));
  ASSERT_EQ(path.size(), 2U);
  EXPECT_EQ(path.back().pose.x, 7.0);
}

TEST(Trajectory, InterpolatesAlongTheArc) {
  // A quarter of a circle of radius 2 around (0, 2).
  const Trajectory path({{{0}, {0.0, 0.0, 0.0}}, {{100}, {2.0, 2.0, 0.5 * kPi}}});
  const double eighth = 0.25 * kPi;
  EXPECT_TRUE(pose_near(*path.at({50}),
                        {2.0 * std::sin(eighth), 2.0 - 2.0 * std::cos(eighth), eighth}, 1e-12,
                        1e-12));
  EXPECT_EQ(*path.at({0}), path.front().pose);
  EXPECT_EQ(*path.at({100}), path.back().pose);
  EXPECT_FALSE(path.at({-1}).has_value());
  EXPECT_FALSE(path.at({101}).has_value());
  EXPECT_EQ(*path.at_clamped({-1}), path.front().pose);
  EXPECT_EQ(*path.at_clamped({101}), path.back().pose);
}

TEST(Trajectory, InterpolatesHeadingsTheShortWayRound) {
  const Trajectory path({{{0}, {0.0, 0.0, kPi - 0.1}}, {{10}, {0.0, 0.0, -kPi + 0.1}}});
  EXPECT_NEAR(std::abs(path.at({5})->yaw), kPi, 1e-12);
}

TEST(Trajectory, KeepsNanosecondsApartAtUnixTimes) {
  const std::int64_t now = 1'700'000'000'000'000'000;
  const Trajectory path({{{now}, {0.0, 0.0, 0.0}}, {{now + 10}, {1.0, 0.0, 0.0}}});
  EXPECT_NEAR(path.at({now + 3})->x, 0.3, 1e-12);
}

TEST(Trajectory, PathLengthCountsTravelNotTurning) {
  const Trajectory path({{{0}, {0.0, 0.0, 0.0}},
                         {{1}, {3.0, 4.0, 0.0}},
                         {{2}, {3.0, 4.0, 2.0}},
                         {{3}, {3.0, 3.0, 2.0}}});
  EXPECT_DOUBLE_EQ(path.path_length_m(), 6.0);
}

RC_GTEST_PROP(TrajectoryLaws, NearestIsThatOfALinearSearch, ()) {
  const auto stamps =
      *rc::gen::nonEmpty(rc::gen::container<std::vector<int>>(rc::gen::inRange(-50, 50)));
  std::vector<StampedPose2> poses;
  for (const int stamp : stamps) poses.push_back({{stamp}, {static_cast<double>(stamp), 0.0, 0.0}});
  const Trajectory path(poses);
  const int query = *rc::gen::inRange(-70, 70);
  const int tolerance = *rc::gen::inRange(0, 20);
  int best = 1000;
  for (const int stamp : stamps) best = std::min(best, std::abs(stamp - query));
  const auto found = path.nearest({query}, {tolerance});
  RC_ASSERT(found.has_value() == (best <= tolerance));
  if (found) RC_ASSERT(std::abs(found->x - query) == best);
}

RC_GTEST_PROP(TrajectoryLaws, ConstantMotionIsReproducedEverywhere, ()) {
  const Tangent2 twist = 0.2 * *test::any_tangent2();
  const Pose2 start = *test::any_pose2();
  Trajectory path;
  for (int i = 0; i <= 4; ++i) path.append({i * 1000}, start * exp(Tangent2(i * twist)));
  const int at = *rc::gen::inRange(0, 4001);
  RC_ASSERT(pose_near(*path.at({at}), start * exp(Tangent2(at / 1000.0 * twist)), 1e-8, 1e-8));
}

}  // namespace
}  // namespace loopstone
