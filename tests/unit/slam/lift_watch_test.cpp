#include "loopstone/slam/lift_watch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/saved_state.hpp"

namespace loopstone {
namespace {

/// A robot of which ten scans a second are told.
class Robot {
 public:
  void scan(bool sees_translation = true, bool sees_rotation = true) {
    ++scans_;
    watch.add(stamp(), reading, pose, sees_translation, sees_rotation);
  }
  /// One step of a drive, by its wheels.
  void drives(double metres, double radians) {
    pose = pose * Pose2{metres, 0.0, radians};
    reading.odom_T_robot = reading.odom_T_robot * Pose2{metres, 0.0, radians};
    reading.path_m += std::abs(metres);
    reading.turned_rad += std::abs(radians);
    scan();
  }
  void stands(int scans) {
    for (int i = 0; i < scans; ++i) scan();
  }
  /// One step in somebody's hands. \param felt  by a gyro
  void is_carried(double metres, double radians, bool felt = false, bool sees_translation = true) {
    pose = pose * Pose2{metres, 0.0, radians};
    if (felt) {
      reading.odom_T_robot.yaw += radians;
      reading.turned_rad += std::abs(radians);
      reading.turned_by_hand_rad += std::abs(radians);
    }
    scan(sees_translation);
  }
  [[nodiscard]] Stamp stamp() const { return Stamp::from_seconds(100.0 + 0.1 * scans_); }

  LiftWatch watch{};
  Pose2 pose{1.0, 2.0, 3.0};
  OdometryReading reading{};

 private:
  int scans_ = 0;
};

TEST(LiftWatch, ARobotThatTurnsOnWheelsThatStandIsInSomebodysHands) {
  for (const bool felt : {false, true}) {
    Robot robot;
    for (int i = 0; i < 20; ++i) robot.drives(0.05, 0.01);
    robot.stands(10);
    EXPECT_FALSE(robot.watch.is_lifted());
    const Stamp lifted = robot.stamp();
    for (int i = 0; i < 20; ++i) robot.is_carried(0.0, 0.03, felt, i < 5);
    ASSERT_TRUE(robot.watch.is_lifted());
    EXPECT_NEAR(robot.watch.felt_rad(robot.reading), felt ? 0.6 : 0.0, 1e-9);
    EXPECT_FALSE(robot.watch.ended_by(robot.reading));
    OdometryReading after = robot.reading;
    after.odom_T_robot.x += 0.05;
    after.path_m += 0.05;
    const auto lift = robot.watch.ended_by(after);
    ASSERT_TRUE(lift);
    EXPECT_NEAR((lift->from - lifted).seconds(), 0.1, 0.051);  // of three hundredths no one knows
    EXPECT_NEAR(lift->unseen_s, 1.5, 1e-6);
    robot.drives(0.05, 0.0);
    EXPECT_FALSE(robot.watch.is_lifted());
  }
}

TEST(LiftWatch, SoIsOneThatMovesAside) {
  Robot robot;
  robot.stands(5);
  for (int i = 0; i < 8; ++i) robot.is_carried(0.08, 0.0);
  EXPECT_FALSE(robot.watch.is_lifted());  // not for long enough
  robot.is_carried(0.08, 0.0);
  EXPECT_TRUE(robot.watch.is_lifted());
}

TEST(LiftWatch, ADriveIsNone) {
  Robot robot;
  for (int i = 0; i < 300; ++i) {
    robot.drives(0.05 * (i % 3), 0.06 * std::sin(0.1 * i));
    EXPECT_FALSE(robot.watch.is_lifted());
  }
  for (int i = 0; i < 100; ++i) {  // on the spot
    robot.drives(0.0, 0.05);
    EXPECT_FALSE(robot.watch.is_lifted());
  }
}

/// Wheels that report late stand for the laser when the robot turns already.
TEST(LiftWatch, NorIsATurnThatWheelsTellLater) {
  Robot robot;
  robot.stands(10);
  for (int i = 0; i < 40; ++i) {
    robot.pose.yaw += 0.1;
    if (i >= 6) {
      robot.reading.odom_T_robot.yaw += 0.1;
      robot.reading.turned_rad += 0.1;
    }
    robot.scan();
    EXPECT_FALSE(robot.watch.is_lifted()) << i;
  }
}

/// For an hour, by a laser that is uncertain by a centimetre.
TEST(LiftWatch, NorIsStanding) {
  Robot robot;
  const Pose2 there = robot.pose;
  for (int i = 0; i < 36'000; ++i) {
    robot.pose = there * Pose2{0.01 * std::sin(0.7 * i), 0.01 * std::cos(i), 0.01 * std::sin(i)};
    robot.scan(i % 5 == 0, i % 7 != 0);
    ASSERT_FALSE(robot.watch.is_lifted());
  }
}

/// Odometry is stuck, and says so until it is not any more.
TEST(LiftWatch, NorAreWheelsThatStandForLong) {
  Robot robot;
  robot.stands(5);
  int lifted = 0;
  int over = 0;
  for (int i = 0; i < 300; ++i) {
    if (robot.watch.ended_by(robot.reading)) ++over;
    robot.is_carried(0.05, 0.01);
    if (robot.watch.is_lifted()) ++lifted;
  }
  EXPECT_NEAR(lifted, 72, 3);
  EXPECT_EQ(over, 1);
  for (int i = 0; i < 5; ++i) robot.drives(0.05, 0.0);
  for (int i = 0; i < 20; ++i) robot.is_carried(0.05, 0.01);
  EXPECT_TRUE(robot.watch.is_lifted());
}

TEST(LiftWatch, WhatTheLaserDoesNotSeeIsNone) {
  Robot robot;
  robot.stands(5);
  for (int i = 0; i < 50; ++i) {
    robot.pose.yaw += 0.05;
    robot.scan(false, false);
  }
  EXPECT_FALSE(robot.watch.is_lifted());
}

TEST(LiftWatch, IsForgottenWhereNothingTellsOfTheWheels) {
  Robot robot;
  robot.stands(5);
  for (int i = 0; i < 20; ++i) robot.is_carried(0.0, 0.05);
  ASSERT_TRUE(robot.watch.is_lifted());
  robot.watch.forget();
  EXPECT_FALSE(robot.watch.is_lifted());
}

TEST(LiftWatch, GoesOnFromItsState) {
  Robot robot;
  robot.stands(5);
  for (int i = 0; i < 7; ++i) robot.is_carried(0.0, 0.05, false, false);
  LiftWatch resumed;
  test::restore(resumed, test::state_of(robot.watch));
  robot.watch = resumed;
  for (int i = 0; i < 3; ++i) robot.is_carried(0.0, 0.05, false, false);
  ASSERT_TRUE(robot.watch.is_lifted());
  LiftWatch::State broken = robot.watch.state();
  broken.stands.reset();
  EXPECT_THROW(resumed.restore(broken), UsageError);
}

}  // namespace
}  // namespace loopstone
