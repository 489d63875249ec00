#include "support/segment_world.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "loopstone/geometry/angle.hpp"
#include "support/pose_near.hpp"

namespace loopstone::test {
namespace {

TEST(SegmentWorld, RayMeetsTheNearestWallAndNothingBehind) {
  const Walls walls =
      together({rectangle({-1.0, -2.0}, {3.0, 4.0}), rectangle({2.0, -0.5}, {2.5, 0.5})});
  const Eigen::Vector2d origin(0.0, 0.0);
  EXPECT_DOUBLE_EQ(cast_ray(walls, origin, {1.0, 0.0}), 2.0);
  EXPECT_DOUBLE_EQ(cast_ray(walls, origin, {-1.0, 0.0}), 1.0);
  EXPECT_DOUBLE_EQ(cast_ray(walls, origin, {0.0, 1.0}), 4.0);
  EXPECT_DOUBLE_EQ(cast_ray(walls, origin, {0.0, -1.0}), 2.0);
  EXPECT_NEAR(cast_ray(walls, origin, {-std::sqrt(0.5), -std::sqrt(0.5)}), std::sqrt(2.0), 1e-12);
  EXPECT_EQ(cast_ray(rectangle({5.0, 5.0}, {6.0, 6.0}), origin, {1.0, 0.0}), INFINITY);
}

TEST(SegmentWorld, DistanceIsToTheSegmentNotToItsLine) {
  const Walls walls{{{0.0, 0.0}, {1.0, 0.0}}};
  EXPECT_DOUBLE_EQ(distance_to_walls(walls, {0.5, -2.0}), 2.0);
  EXPECT_DOUBLE_EQ(distance_to_walls(walls, {4.0, 4.0}), 5.0);
}

TEST(SegmentWorld, ScanEndsOnWalls) {
  const Walls room = furnished_room();
  const Pose2 world_T_robot{4.0, 3.0, 0.7};
  const Pose2 robot_T_lidar{0.2, -0.1, 0.3};
  const LaserScan scan = scan_from(room, world_T_robot, robot_T_lidar, {});
  ASSERT_EQ(scan.ranges_m.size(), 541U);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double angle = scan.angle_rad(i);
    const Eigen::Vector2d end =
        scan.ranges_m[i] * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    EXPECT_LT(distance_to_walls(room, world_T_robot * robot_T_lidar * end), 1e-5);
  }
}

TEST(SegmentWorld, SweepOfATurningRobotIsDistorted) {
  const Walls room = furnished_room();
  const Scanner slow{.time_increment_s = 0.001};
  const auto still = scan_from(room, {4.0, 3.0, 0.0}, {}, slow);
  const auto turning = scan_from(room, {4.0, 3.0, 0.0}, {}, slow, nullptr, {0.0, 0.0, 1.0});
  EXPECT_EQ(still.ranges_m.front(), turning.ranges_m.front());
  EXPECT_NE(still.ranges_m.back(), turning.ranges_m.back());
}

TEST(SegmentWorld, NoiseHasTheSpreadAskedFor) {
  Rng rng(1);
  const Scanner noisy{.noise_m = 0.02};
  double sum = 0.0;
  int count = 0;
  const auto clean = scan_from(furnished_room(), {4.0, 3.0, 0.0}, {}, {});
  for (int k = 0; k < 20; ++k) {
    const auto scan = scan_from(furnished_room(), {4.0, 3.0, 0.0}, {}, noisy, &rng);
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i, ++count) {
      sum += std::pow(scan.ranges_m[i] - clean.ranges_m[i], 2);
    }
  }
  EXPECT_NEAR(std::sqrt(sum / count), 0.02, 0.001);
}

TEST(SegmentWorld, DriveVisitsItsPointsInSmallSteps) {
  const std::vector<Eigen::Vector2d> points{{0.0, 0.0}, {2.0, 0.0}, {2.0, 1.0}, {1.0, 1.0}};
  const auto poses = drive_through(points, 0.1, 0.1);
  EXPECT_TRUE(pose_near(poses.front(), {0.0, 0.0, 0.0}, 1e-12, 1e-12));
  EXPECT_TRUE(pose_near(poses.back(), {1.0, 1.0, kPi}, 1e-12, 1e-12));
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Pose2 step = poses[i - 1].inverse() * poses[i];
    EXPECT_LE(std::hypot(step.x, step.y), 0.1 + 1e-9);
    EXPECT_LE(std::abs(step.yaw), 0.1 + 1e-9);
    EXPECT_GT(std::hypot(step.x, step.y) + std::abs(step.yaw), 1e-6) << "the robot stops at " << i;
  }
}

TEST(PoseNear, ComparesHeadingsAcrossTheWrapAndRefusesNaN) {
  EXPECT_TRUE(pose_near({0.0, 0.0, kPi - 0.001}, {0.0, 0.0, -kPi + 0.001}, 1e-9, 0.0021));
  EXPECT_FALSE(pose_near({0.0, 0.0, -0.5}, {0.0, 0.0, 0.0}, 1e-9, 0.1));
  EXPECT_FALSE(pose_near({0.2, 0.0, 0.0}, {0.0, 0.0, 0.0}, 0.1, 0.1));
  EXPECT_FALSE(pose_near({NAN, 0.0, 0.0}, {0.0, 0.0, 0.0}, 0.1, 0.1));
  EXPECT_FALSE(pose_near({0.0, 0.0, NAN}, {0.0, 0.0, 0.0}, 0.1, 0.1));
}

}  // namespace
}  // namespace loopstone::test
