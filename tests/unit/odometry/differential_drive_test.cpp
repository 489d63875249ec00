#include "loopstone/odometry/differential_drive.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace loopstone {
namespace {

TEST(CountDifference, SeesThroughAWrapInBothDirections) {
  EXPECT_EQ(count_difference(10, 13, 32), 3);
  EXPECT_EQ(count_difference(13, 10, 32), -3);
  EXPECT_EQ(count_difference(65534, 2, 16), 4);
  EXPECT_EQ(count_difference(2, 65534, 16), -4);
  EXPECT_EQ(count_difference(32767, -32768, 16), 1) << "signed 16-bit counters wrap too";
  EXPECT_EQ(count_difference(-(std::int64_t{1} << 61), (std::int64_t{1} << 61) - 1, 62), -1);
}

TEST(CountDifference, AgreesWithACounterThatNeverWraps) {
  // The naive twin: a wide counter, of which the narrow one shows the lowest bits.
  for (const int bits : {8, 12, 16, 31}) {
    const std::int64_t modulus = std::int64_t{1} << bits;
    std::int64_t wide = 0;
    for (int i = 0; i < 1000; ++i) {
      const std::int64_t step = (i * 37) % (modulus / 2 - 1) - modulus / 4;
      const std::int64_t before = ((wide % modulus) + modulus) % modulus;
      wide += step;
      const std::int64_t after = ((wide % modulus) + modulus) % modulus;
      ASSERT_EQ(count_difference(before, after, bits), step) << bits << " bits, step " << i;
    }
  }
}

TEST(MotionOf, TakesTheWheelsInTheOrderOfTheLog) {
  WheelModel wheels;
  wheels.metres_per_count = 0.01;
  wheels.track_width_m = 0.5;
  // [FR, FL, RR, RL]: right 0.12 m, left 0.08 m.
  const ArcMotion motion = motion_of({13, 7, 11, 9}, wheels);
  EXPECT_NEAR(motion.distance_m, 0.10, 1e-15);
  EXPECT_NEAR(motion.rotation_rad, 0.08, 1e-15) << "faster on the right turns left";
}

TEST(IntegrateArc, DrivesAQuarterOfACircle) {
  const double radius_m = 2.0;
  const Pose2 end = integrate_arc({radius_m * kPi / 2.0, kPi / 2.0});
  EXPECT_NEAR(end.x, radius_m, 1e-12);
  EXPECT_NEAR(end.y, radius_m, 1e-12);
  EXPECT_NEAR(end.yaw, kPi / 2.0, 1e-12);
}

TEST(IntegrateArc, DoesNotDependOnHowTheMotionIsCut) {
  const Pose2 whole = integrate_arc({1.3, 0.9});
  Pose2 parts;
  for (int i = 0; i < 10; ++i) parts = parts * integrate_arc({0.13, 0.09});
  EXPECT_NEAR(whole.x, parts.x, 1e-12);
  EXPECT_NEAR(whole.y, parts.y, 1e-12);
  EXPECT_NEAR(whole.yaw, parts.yaw, 1e-12);
}

TEST(IntegrateEuler, ErrsSidewaysByHalfDistanceTimesTurn) {
  const ArcMotion motion{0.02, 0.01};
  const Pose2 arc = integrate_arc(motion);
  const Pose2 euler = integrate_euler(motion);
  EXPECT_NEAR(arc.y - euler.y, 0.5 * 0.02 * 0.01, 1e-9);
  EXPECT_EQ(euler.yaw, arc.yaw);
}

TEST(IntegrateEuler, ConvergesToTheArcAsStepsShrink) {
  const auto error = [](int steps) {
    Pose2 pose;
    for (int i = 0; i < steps; ++i) pose = pose * integrate_euler({1.0 / steps, 1.0 / steps});
    return (pose.translation() - integrate_arc({1.0, 1.0}).translation()).norm();
  };
  EXPECT_NEAR(error(100) / error(1000), 10.0, 0.1) << "Euler's method is of first order";
}

TEST(MotionCovariance, DoesNotDependOnHowThePathIsCut) {
  const OdometryOptions options;
  const Eigen::Matrix3d whole = motion_covariance(2.0, 0.5, false, options);
  const Eigen::Matrix3d part = motion_covariance(0.02, 0.005, false, options);
  EXPECT_LT((whole - 100.0 * part).norm(), 1e-12);
  EXPECT_GT(whole(2, 2), motion_covariance(2.0, 0.5, true, options)(2, 2));
}

}  // namespace
}  // namespace loopstone
