#include "mapping/smooth_pose.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

Stamp at_s(double seconds) { return Stamp::from_seconds(seconds); }

/// Goes to and fro, turning through half a turn and back.
Pose2 truth(double t) {
  return {0.6 * std::sin(0.9 * t), 0.3 * t, wrap_angle(3.0 + 0.8 * std::sin(1.5 * t))};
}

TEST(SmoothPose, IsFarNearerToASmoothMotionThanTheArc) {
  Trajectory trajectory;
  for (int i = 0; i <= 100; ++i) trajectory.append(at_s(0.1 * i), truth(0.1 * i));
  double worst_yaw = 0.0;
  double worst_arc_yaw = 0.0;
  double worst_m = 0.0;
  for (double t = 0.2; t < 9.8; t += 0.0137) {
    const Pose2 smooth = *smooth_pose_at(trajectory, at_s(t));
    const Pose2 arc = *trajectory.at(at_s(t));
    worst_yaw = std::max(worst_yaw, std::abs(wrap_angle(smooth.yaw - truth(t).yaw)));
    worst_arc_yaw = std::max(worst_arc_yaw, std::abs(wrap_angle(arc.yaw - truth(t).yaw)));
    worst_m = std::max(worst_m, (smooth.translation() - truth(t).translation()).norm());
  }
  EXPECT_GT(worst_arc_yaw, 0.002);
  EXPECT_LT(worst_yaw, 0.1 * worst_arc_yaw);
  EXPECT_LT(worst_m, 5e-5);
}

TEST(SmoothPose, PassesThroughThePosesAndEndsWhereTheyEnd) {
  Trajectory trajectory;
  for (const double t : {0.0, 0.1, 0.17, 0.3, 0.42, 0.5}) trajectory.append(at_s(t), truth(t));
  for (const StampedPose2& pose : trajectory.poses()) {
    const auto found = smooth_pose_at(trajectory, pose.stamp);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR((found->translation() - pose.pose.translation()).norm(), 0.0, 1e-12);
    EXPECT_NEAR(wrap_angle(found->yaw - pose.pose.yaw), 0.0, 1e-12);
  }
  EXPECT_FALSE(smooth_pose_at(trajectory, at_s(-0.01)).has_value());
  EXPECT_FALSE(smooth_pose_at(trajectory, at_s(0.51)).has_value());
  EXPECT_TRUE(smooth_pose_at(trajectory, at_s(0.05)).has_value());
  EXPECT_FALSE(smooth_pose_at(Trajectory{}, at_s(0.0)).has_value());
}

TEST(SmoothPose, TakesTheArcAcrossAGap) {
  Trajectory trajectory;
  for (const double t : {0.0, 0.1, 0.9, 1.0, 1.1}) trajectory.append(at_s(t), truth(t));
  const Pose2 smooth = *smooth_pose_at(trajectory, at_s(0.5));
  const Pose2 arc = *trajectory.at(at_s(0.5));
  EXPECT_EQ(smooth.x, arc.x);
  EXPECT_EQ(smooth.yaw, arc.yaw);
}

}  // namespace
}  // namespace loopstone
