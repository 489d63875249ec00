#include "slam/turning_beams.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

/// Of a laser that turns on the spot, off the middle of a room of 9 by 5 m.
LaserScan scan_at(double yaw_rad, bool mirrored, double fov_rad = kPi) {
  LaserScan scan{
      .angle_min_rad = -0.5 * fov_rad, .angle_increment_rad = fov_rad / 180.0, .range_max_m = 30.0};
  for (int i = 0; i <= 180; ++i) {
    const double angle = scan.angle_rad(static_cast<std::size_t>(i));
    const double bearing = yaw_rad + (mirrored ? -angle : angle);
    const double c = std::cos(bearing);
    const double s = std::sin(bearing);
    const double x_m = (c > 0.0 ? 7.0 : -2.0) / c;
    const double y_m = (s > 0.0 ? 3.5 : -1.5) / s;
    scan.ranges_m.push_back(static_cast<float>(std::min(x_m, y_m)));
  }
  return scan;
}

TEST(TurningBeams, TellWhichWayTheRobotTurned) {
  for (const double fov_rad : {0.7 * kPi, kPi, 2.0 * kPi}) {
    for (const double yaw_rad : {-2.0, -0.4, 0.3, 1.7}) {
      for (const double turn_rad : {-0.5, 0.3}) {
        const auto told = [&](bool mirrored) {
          return told_turn(scan_at(yaw_rad, mirrored, fov_rad),
                           scan_at(yaw_rad + turn_rad, mirrored, fov_rad), turn_rad);
        };
        EXPECT_EQ(told(false), 1) << fov_rad << " " << yaw_rad << " " << turn_rad;
        EXPECT_EQ(told(true), -1) << fov_rad << " " << yaw_rad << " " << turn_rad;
      }
    }
  }
}

TEST(TurningBeams, WhatLooksTheSameAllAroundTellsNothing) {
  LaserScan round = scan_at(0.0, false);
  std::ranges::fill(round.ranges_m, 2.0F);
  EXPECT_EQ(told_turn(round, round, 0.4), 0);
  std::ranges::fill(round.ranges_m, std::numeric_limits<float>::infinity());
  EXPECT_EQ(told_turn(round, round, 0.4), 0) << "nor where nothing returns";
}

/// Ten scans a second of a robot that turns to and fro.
TurnVotes votes_of(double scans_mirrored_from_s, double turn_m = 0.0) {
  std::vector<SubmapRecord> submaps(2);
  std::deque<TrackedPose> track;
  for (std::size_t i = 0; i < 300; ++i) {
    const double time_s = 0.1 * static_cast<double>(i);
    const double yaw_rad = 2.0 * std::sin(0.4 * time_s);
    LaserScan scan = scan_at(yaw_rad, time_s >= scans_mirrored_from_s);
    scan.stamp = Stamp::from_seconds(100.0 + time_s);
    track.push_back({scan.stamp, Pose2{}, Pose2{turn_m * static_cast<double>(i), 0.0, yaw_rad}});
    submaps[i / 150].scans.add(
        std::make_shared<const MappedScan>(MappedScan{.scan = std::move(scan), .index = i}));
  }
  EXPECT_EQ(turn_votes(submaps, track, 1).same, 0) << "another laser";
  return turn_votes(submaps, track, 0);
}

TEST(TurningBeams, ALaserUpsideDownIsOneThatTurnsTheOtherWayAllAlong) {
  const TurnVotes upright = votes_of(1e9);
  EXPECT_GT(upright.same, 30);
  EXPECT_EQ(upright.opposite, 0);
  EXPECT_FALSE(upright.are_opposite());
  const TurnVotes upside_down = votes_of(0.0);
  EXPECT_GT(upside_down.opposite, 30);
  EXPECT_EQ(upside_down.same, 0);
  EXPECT_TRUE(upside_down.are_opposite());
  const double span_s = (upside_down.last - *upside_down.first).seconds();
  EXPECT_TRUE(upside_down.are_all_along(Duration::from_seconds(1.9 * span_s)));
  EXPECT_FALSE(upside_down.are_all_along(Duration::from_seconds(2.1 * span_s)));
  EXPECT_FALSE(TurnVotes{}.are_all_along(Duration{}));
  EXPECT_FALSE(votes_of(15.0).are_opposite()) << "half of the time";
  EXPECT_FALSE((TurnVotes{0, 3}.are_opposite())) << "chance";
  const TurnVotes driving = votes_of(0.0, 0.3);
  EXPECT_EQ(driving.same + driving.opposite, 0) << "ranges change as it drives";
}

}  // namespace
}  // namespace loopstone
