// Returns from right in front of the laser: a wall, or its own cover.

#include "loopstone/slam/laser_cover.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace loopstone {
namespace {

constexpr int kBeams = 181;

/// Of a room 6 m x 4 m about the origin, as a laser there sees it.
LaserScan room_from(const Pose2& room_T_lidar) {
  LaserScan scan;
  scan.angle_min_rad = -0.5 * std::numbers::pi;
  scan.angle_increment_rad = std::numbers::pi / (kBeams - 1);
  scan.range_max_m = 30.0;
  for (int i = 0; i < kBeams; ++i) {
    const double angle = room_T_lidar.yaw + scan.angle_rad(static_cast<std::size_t>(i));
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const double to_x = (c > 0.0 ? 3.0 - room_T_lidar.x : -3.0 - room_T_lidar.x) / c;
    const double to_y = (s > 0.0 ? 2.0 - room_T_lidar.y : -2.0 - room_T_lidar.y) / s;
    scan.ranges_m.push_back(static_cast<float>(std::min(to_x, to_y)));
  }
  return scan;
}

/// A submap of a drive through the room.
class LaserCoverOf : public testing::Test {
 protected:
  LaserCoverOf() {
    const SurfaceOptions options{.range_max_m = 30.0, .points_max = 360};
    for (double x = -2.0; x <= 2.4; x += 0.2) {
      for (const double yaw : {0.0, 1.5}) {
        const Pose2 pose{x, 0.0, yaw};
        const LaserScan scan = room_from(pose);
        const auto surfaces = surface_points(scan, Pose2{}, Tangent2::Zero(), options, beams_);
        submap_.insert(surfaces, scan, Pose2{}, pose, beams_);
      }
    }
  }
  [[nodiscard]] LaserCover cover(const LaserScan& scan, const Pose2& pose,
                                 bool is_measured = true) {
    return cover_of(scan, pose, is_measured, submap_, beams_);
  }
  [[nodiscard]] bool covered(const LaserScan& scan, const Pose2& pose) {
    return !cover(scan, pose).beams.empty();
  }

  BeamTable beams_{};
  Submap submap_{SubmapOptions{}};
};

TEST_F(LaserCoverOf, WallsThatAreKnownAreNone) {
  // As near as 20 cm.
  for (const double x : {-1.0, 0.0, 2.0, 2.6, 2.8}) {
    EXPECT_FALSE(covered(room_from({x, 0.0, 0.0}), {x, 0.0, 0.0})) << x;
  }
}

TEST_F(LaserCoverOf, WhatStandsInFreeSpaceRightBeforeItIs) {
  const Pose2 pose{0.3, 0.1, 0.2};
  LaserScan scan = room_from(pose);
  // Every fifth beam ends on something that is not there.
  for (std::size_t i = 0; i < scan.ranges_m.size(); i += 5) {
    scan.ranges_m[i] = 0.05F + 0.01F * static_cast<float>(i % 24);
  }
  const LaserCover found = cover(scan, pose);
  ASSERT_FALSE(found.beams.empty());
  EXPECT_TRUE(found.is_fault);
  take_out(found.beams, scan);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    EXPECT_EQ(std::isnan(scan.ranges_m[i]), i % 5 == 0) << i;
  }
  EXPECT_FALSE(covered(scan, pose));
}

TEST_F(LaserCoverOf, LegsAreTooFew) {
  const Pose2 pose{0.3, 0.1, 0.2};
  LaserScan scan = room_from(pose);
  for (std::size_t i = 60; i < 70; ++i) scan.ranges_m[i] = 0.4F;
  EXPECT_FALSE(covered(scan, pose));
}

TEST_F(LaserCoverOf, PeopleAroundAreTakenOutWhole) {
  const Pose2 pose{0.3, 0.1, 0.2};
  LaserScan scan = room_from(pose);
  const auto is_person = [](std::size_t i) { return i % 30 < 10; };  // a third of what is seen
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (is_person(i)) scan.ranges_m[i] = 1.0F;
  }
  const LaserCover found = cover(scan, pose);
  ASSERT_FALSE(found.beams.empty());
  EXPECT_TRUE(found.is_fault);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    EXPECT_EQ(found.beams[i], is_person(i)) << i;
  }
  EXPECT_TRUE(cover(scan, pose, false).beams.empty()) << "a guess that is off looks like that";
}

TEST_F(LaserCoverOf, ARobotThatIsElsewhereSeesNoStrangers) {
  // Most of what it sees would stand in free space, and nothing else agrees either.
  const LaserScan scan = room_from({1.5, 1.2, 0.9});
  EXPECT_FALSE(covered(scan, {-1.0, -0.5, 0.0}));
}

TEST_F(LaserCoverOf, WhereNothingIsKnownNothingIsSaid) {
  const Pose2 outside{20.0, 20.0, 0.0};
  LaserScan scan = room_from({});
  for (float& range_m : scan.ranges_m) range_m = 0.2F;
  EXPECT_FALSE(covered(scan, outside));
}

}  // namespace
}  // namespace loopstone
