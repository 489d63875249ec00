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

TEST(OdometryAccuracy, BeginsAsWheelsThatNobodyKnows) {
  const OdometryAccuracy accuracy;
  EXPECT_NEAR(accuracy.sigma_m(2.0, 0.0), 0.3, 1e-9);
  EXPECT_NEAR(accuracy.sigma_rad(2.0), 0.06, 1e-9);
  EXPECT_EQ(accuracy.sigma_m(0.0, 0.0), 0.0);
}

TEST(OdometryAccuracy, LearnsHowFarOffWheelsAre) {
  EXPECT_NEAR(driven(1.05, 0.0).sigma_m(4.0, 0.0), 4.0 * 0.05, 0.05);
  EXPECT_NEAR(driven(1.0, 0.01).sigma_rad(4.0), 4.0 * 0.01, 0.01);
  EXPECT_LT(driven(1.0, 0.0).sigma_m(4.0, 0.0), 0.15);
  EXPECT_GT(driven(1.0, 0.0).sigma_m(4.0, 0.0), 0.05) << "no wheels are perfect";
}

TEST(OdometryAccuracy, ErrorsOfManyWindowsAddUpAndAHeadingSwingsWhatIsFar) {
  const OdometryAccuracy accuracy = driven(1.05, 0.01);
  EXPECT_NEAR(accuracy.sigma_m(16.0, 0.0) / accuracy.sigma_m(4.0, 0.0), 2.0, 1e-9);
  EXPECT_NEAR(accuracy.sigma_m(16.0, 16.0),
              std::hypot(accuracy.sigma_m(16.0, 0.0), 8.0 * accuracy.sigma_rad(16.0)), 1e-9);
}

TEST(OdometryAccuracy, WhatTheLaserDidNotSeeTeachesNothing) {
  OdometryAccuracy accuracy;
  for (int i = 0; i < 1000; ++i) {
    const double x = 0.1 * i;
    if (i % 20 == 0) accuracy.interrupt();
    accuracy.add(Pose2{3.0 * x, 0.0, 0.0}, Pose2{x, 0.0, 0.0}, x);
  }
  EXPECT_NEAR(accuracy.sigma_m(2.0, 0.0), 0.3, 1e-9);
}

}  // namespace
}  // namespace loopstone
