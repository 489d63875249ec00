#include "loopstone/odometry/odometry_correction.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::pose_near;

TEST(OdometryCorrection, OfNothingKnownIsNone) {
  const Pose2 said{0.3, -0.1, 2.0};
  EXPECT_EQ(OdometryCorrection{}.corrected(said, 0.5), said);
}

TEST(OdometryCorrection, AWayThatWasSaidToBeStraightIsAnArc) {
  const OdometryCorrection correction{.scale = 1.25, .rad_per_m = 0.02};
  // 5 m as odometry says, 4 m in truth, a tenth of a radian to the left.
  const double radius_m = 4.0 / 0.1;
  const Pose2 arc{radius_m * std::sin(0.1), radius_m * (1.0 - std::cos(0.1)), 0.1};
  EXPECT_TRUE(pose_near(correction.corrected({5.0, 0.0, 0.0}, 5.0), arc, 1e-9, 1e-9));
}

TEST(OdometryCorrection, StepsAddUpToTheWhole) {
  const OdometryCorrection correction{.rad_per_m = -0.03, .rad_per_turn = 0.05};
  const Pose2 whole = exp(Tangent2(2.0, 0.0, 0.6));
  Pose2 steps;
  for (int i = 0; i < 20; ++i)
    steps = steps * correction.corrected(exp(Tangent2(0.1, 0.0, 0.03)), 0.1);
  EXPECT_TRUE(pose_near(steps, correction.corrected(whole, 2.0), 1e-3, 1e-9));
  EXPECT_NEAR(steps.yaw, 0.6 * 1.05 - 0.06, 1e-9);
}

TEST(OdometryCorrection, BackwardsWheelsTurnTheRobotTheOtherWay) {
  const OdometryCorrection correction{.rad_per_m = 0.02};
  EXPECT_NEAR(correction.corrected({-1.0, 0.0, 0.0}, 1.0).yaw, -0.02, 1e-9);
  EXPECT_NEAR(correction.corrected({0.0, 0.0, 0.0}, 6.0).yaw, 0.12, 1e-9) << "there and back";
}

}  // namespace
}  // namespace loopstone
