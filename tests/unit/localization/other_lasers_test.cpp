#include "localization/other_lasers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "drawn_room.hpp"

namespace loopstone {
namespace {

using test::furnished_room;
using test::scan_from;
using test::Walls;

const Pose2 kFront{0.3, 0.1, 0.4};
const Pose2 kRear{-0.3, -0.1, 0.4 - kPi};
const Pose2 kThen{3.0, 3.0, 0.3};
constexpr int kFrontLaser = 0;
constexpr int kRearLaser = 1;

Stamp at(double seconds) { return Stamp::from_seconds(seconds); }

SeenByLaser seen_from(const Pose2& pose, const Pose2& mount) {
  return view_of_laser(scan_from(furnished_room(), pose, mount, {}), mount, Tangent2::Zero(), 90);
}

TEST(OtherLasers, WhatTheySawLiesWhereItIsFromWhereTheRobotDroveTo) {
  const Walls room = furnished_room();
  const Pose2 step{0.15, 0.02, 0.1};
  OtherLasers others;
  others.remember(kRearLaser, at(10.0), seen_from(kThen, kRear));
  others.move(step);
  others.move(step);
  const std::vector<SeenByLaser> beside = others.beside(kFrontLaser, at(10.1));
  ASSERT_EQ(beside.size(), 1U);
  const Pose2 now = kThen * step * step;
  ASSERT_GT(beside.front().points_robot.size(), 100U);
  for (const auto& point : beside.front().points_robot)
    EXPECT_LT(distance_to_walls(room, now * point), 1e-5);
  const SeenByLaser& laser = beside.front();
  for (std::size_t i = 0; i < laser.ranges_m.size(); ++i) {
    const auto range = static_cast<double>(laser.ranges_m[i]);
    const Eigen::Vector2d end{range * std::cos(laser.angles_rad[i]),
                              range * std::sin(laser.angles_rad[i])};
    EXPECT_LT(distance_to_walls(room, now * (laser.robot_T_lidar * end)), 1e-5);
  }
}

TEST(OtherLasers, AMomentLongAndNeverTheScansOwn) {
  OtherLasers others;
  others.remember(kRearLaser, at(10.0), seen_from(kThen, kRear));
  EXPECT_EQ(others.beside(kFrontLaser, at(10.19)).size(), 1U);
  EXPECT_TRUE(others.beside(kFrontLaser, at(10.21)).empty());
  EXPECT_TRUE(others.beside(kRearLaser, at(10.1)).empty());
  others.remember(kFrontLaser, at(10.1), seen_from(kThen, kFront));
  EXPECT_EQ(others.beside(kRearLaser, at(10.1)).size(), 1U);
  EXPECT_EQ(others.beside(2, at(10.15)).size(), 2U);
}

TEST(OtherLasers, TheNewestOfALaserTakesThePlaceOfTheOneBefore) {
  OtherLasers others;
  others.remember(kRearLaser, at(10.0), seen_from(kThen, kRear));
  others.move({0.1, 0.0, 0.0});
  SeenByLaser newest = seen_from(kThen, kRear);
  newest.points_robot.resize(20);
  others.remember(kRearLaser, at(10.1), newest);
  const std::vector<SeenByLaser> beside = others.beside(kFrontLaser, at(10.15));
  ASSERT_EQ(beside.size(), 1U);
  EXPECT_EQ(beside.front().points_robot, newest.points_robot);
}

TEST(OtherLasers, ALaserSeesUnlessItIsCoveredOrShowsNothing) {
  SeenByLaser view = seen_from(kThen, kFront);
  EXPECT_TRUE(sees(view));
  const std::size_t beams = view.ranges_m.size();
  std::fill_n(view.ranges_m.begin(), beams - beams / 8, 0.2F);
  EXPECT_TRUE(sees(view)) << "as between two walls, close by";
  std::fill_n(view.ranges_m.begin(), beams - beams / 12, 0.2F);
  EXPECT_FALSE(sees(view));
  std::ranges::fill(view.ranges_m, std::numeric_limits<float>::infinity());
  view.points_robot.clear();
  EXPECT_FALSE(sees(view));
}

TEST(OtherLasers, TogetherTheyFitTheMapWhereTheRobotIs) {
  const Walls room = furnished_room();
  const LocalizationMap map(test::drawn(room, {0.0, 0.0}, {8.0, 6.0}));
  const LocalizationScan both =
      view_together({seen_from(kThen, kFront), seen_from(kThen, kRear)}, 90);
  ASSERT_EQ(both.lasers.size(), 2U);
  EXPECT_EQ(both.lasers[0].ranges_m.size(), 45U);
  EXPECT_EQ(both.lasers[1].ranges_m.size(), 45U);
  EXPECT_EQ(both.weighed.size(), 90U);
  EXPECT_EQ(both.points_robot.size(),
            both.lasers[0].points_robot.size() + both.lasers[1].points_robot.size());
  const BeamFit fit = fit_beams(both, map, kThen);
  EXPECT_GT(fit.explained, 0.97);
  EXPECT_EQ(fit.violations, 0.0);
  // What one of them contradicts shows in the whole.
  const LocalizationScan turned =
      view_together({seen_from(kThen, kFront), seen_from(kThen * Pose2{0.0, 0.0, 1.0}, kRear)}, 90);
  EXPECT_LT(fit_beams(turned, map, kThen).explained, 0.8);
}

}  // namespace
}  // namespace loopstone
