#include "loopstone/odometry/odometry_accuracy.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace loopstone {
namespace {

/// A straight drive of 10 cm a scan, with wheels that say so many times as much, and turn a little.
OdometryAccuracy driven(double scale, double rad_per_m, int scans = 2000) {
  OdometryAccuracy accuracy;
  for (int i = 0; i < scans; ++i) {
    const double x = 0.1 * i;
    const Pose2 odom{scale * x, 0.0, 0.0};
    accuracy.add(odom, Pose2{x, 0.0, -rad_per_m * x}, scale * x);
  }
  return accuracy;
}

/// One standard deviation after a way that ends where it began.
OdometryAccuracy::Sigma sigma(const OdometryAccuracy& accuracy, double path_m) {
  return accuracy.sigma(path_m, 0.0, {});
}

TEST(OdometryAccuracy, BeginsAsWheelsThatNobodyKnows) {
  const OdometryAccuracy accuracy;
  EXPECT_NEAR(sigma(accuracy, 2.0).m, 0.3, 1e-9);
  EXPECT_NEAR(sigma(accuracy, 2.0).rad, 0.06, 1e-9);
  EXPECT_EQ(sigma(accuracy, 0.0).m, 0.0);
}

TEST(OdometryAccuracy, LearnsHowFarOffWheelsAre) {
  EXPECT_NEAR(sigma(driven(1.05, 0.0), 4.0).m, 4.0 * 0.05, 0.05);
  EXPECT_NEAR(sigma(driven(1.0, 0.01), 4.0).rad, 4.0 * 0.01, 0.01);
  EXPECT_LT(sigma(driven(1.0, 0.0), 4.0).m, 0.15);
  EXPECT_GT(sigma(driven(1.0, 0.0), 4.0).m, 0.05) << "no wheels are perfect";
}

TEST(OdometryAccuracy, WhatIsCorrectedIsNotLeft) {
  OdometryAccuracy veering;  // it says 5 % too much, and that the robot goes straight
  Pose2 local_T_robot;
  for (int i = 0; i < 2000; ++i) {
    veering.add({0.105 * i, 0.0, 0.0}, local_T_robot, 0.105 * i);
    local_T_robot = local_T_robot * exp(Tangent2(0.1, 0.0, 0.002));
  }
  EXPECT_NEAR(sigma(veering, 4.0).rad, 4.0 * 0.019, 0.001);
  const auto left = veering.sigma(4.0, 0.0, {.scale = 1.05, .rad_per_m = 0.02 / 1.05});
  EXPECT_NEAR(left.rad, 4.0 * kOdometryAccuracy.least_rad_per_m, 1e-9);
  EXPECT_NEAR(left.m, 4.0 * kOdometryAccuracy.least_share, 1e-9);
  EXPECT_NEAR(veering.sigma(4.0, 0.0, {.rad_per_m = -0.019}).rad, 4.0 * 0.038, 0.001)
      << "corrected the wrong way";
}

TEST(OdometryAccuracy, TellsWhatTheHeadingIsUsuallyOffBy) {
  EXPECT_FALSE(driven(1.0, 0.0, 100).usual_rad({})) << "after two windows";
  EXPECT_NEAR(driven(1.0, 0.0).usual_rad({}).value(), 0.0, 1e-9);
  EXPECT_NEAR(driven(1.0, 0.01).usual_rad({}).value(), 0.04, 0.002);
}

TEST(OdometryAccuracy, OldWindowsAreForgotten) {
  OdometryAccuracy accuracy = driven(1.2, 0.0, 300);
  const double before_m = sigma(accuracy, 4.0).m;
  for (int i = 0; i < 3000; ++i) {
    const Pose2 pose{0.1 * i, 0.0, 0.0};
    if (i == 0) accuracy.interrupt();
    accuracy.add(pose, pose, pose.x);
  }
  EXPECT_GT(before_m, 0.5);
  EXPECT_NEAR(sigma(accuracy, 4.0).m, 4.0 * kOdometryAccuracy.least_share, 1e-9);
}

TEST(OdometryAccuracy, ErrorsOfManyWindowsAddUpAndAHeadingSwingsWhatIsFar) {
  const OdometryAccuracy accuracy = driven(1.05, 0.01);
  EXPECT_NEAR(sigma(accuracy, 16.0).m / sigma(accuracy, 4.0).m, 2.0, 1e-9);
  EXPECT_NEAR(accuracy.sigma(16.0, 16.0, {}).m,
              std::hypot(sigma(accuracy, 16.0).m, 8.0 * sigma(accuracy, 16.0).rad), 1e-9);
}

TEST(OdometryAccuracy, WhatTheLaserDidNotSeeTeachesNothing) {
  OdometryAccuracy accuracy;
  for (int i = 0; i < 1000; ++i) {
    const double x = 0.1 * i;
    if (i % 20 == 0) accuracy.interrupt();
    accuracy.add(Pose2{3.0 * x, 0.0, 0.0}, Pose2{x, 0.0, 0.0}, x);
  }
  EXPECT_NEAR(sigma(accuracy, 2.0).m, 0.3, 1e-9);
}

}  // namespace
}  // namespace loopstone
