#include "loopstone/report/ros_messages.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "formats/ros_geometry.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::pose_near;

Stamp at(double seconds) { return Stamp::from_seconds(seconds); }

Pose2 pose_of(const msg::TransformStamped& transform) {
  return to_pose2(*to_pose3(transform.transform));
}

const Pose2 kOnMap{4.0, -2.0, 2.5};

/// Along a bow, told at 20 Hz.
Pose2 odom_T_robot(double seconds) { return {std::sin(seconds), seconds, 0.3 * seconds}; }

RobotTransforms driven(double until_s) {
  RobotTransforms transforms({.odom = "robot1/odom", .base = "robot1/base"});
  for (int i = 0; i <= static_cast<int>(until_s * 20.0); ++i)
    transforms.add(OdometryPose{at(i / 20.0), odom_T_robot(i / 20.0)});
  return transforms;
}

TEST(RobotTransforms, LeadWithTheRobotsOdometryToItsPose) {
  const RobotTransforms transforms = driven(10.0);
  for (const double seconds : {3.0, 9.33, 10.0}) {
    const msg::TFMessage message = transforms.at(at(seconds), kOnMap, {100.0, 0.0, 0.0});
    ASSERT_EQ(message.transforms.size(), 1U);
    const msg::TransformStamped& one = message.transforms[0];
    EXPECT_EQ(one.header.frame_id, "map");
    EXPECT_EQ(one.child_frame_id, "robot1/odom");
    EXPECT_EQ(one.header.stamp, at(seconds));
    EXPECT_TRUE(pose_near(pose_of(one) * odom_T_robot(seconds), kOnMap, 2e-3, 1e-3));
  }
}

TEST(RobotTransforms, OfAScanThatIsNewerThanAllOdometryUseTheLast) {
  const msg::TFMessage message = driven(10.0).at(at(10.2), kOnMap, {});
  EXPECT_TRUE(
      pose_near(pose_of(message.transforms.at(0)) * odom_T_robot(10.0), kOnMap, 1e-9, 1e-9));
}

TEST(RobotTransforms, WithoutOdometryLeadToTheRobot) {
  const RobotTransforms transforms(RobotFrames{});
  const msg::TFMessage message = transforms.at(at(1.0), kOnMap, {0.5, 0.25, -1.0});
  ASSERT_EQ(message.transforms.size(), 2U);
  EXPECT_EQ(message.transforms[0].child_frame_id, "odom");
  EXPECT_EQ(message.transforms[1].header.frame_id, "odom");
  EXPECT_EQ(message.transforms[1].child_frame_id, "base_link");
  EXPECT_TRUE(pose_near(pose_of(message.transforms[0]) * pose_of(message.transforms[1]), kOnMap,
                        1e-9, 1e-9));
  EXPECT_TRUE(pose_near(pose_of(message.transforms[1]), {0.5, 0.25, -1.0}, 1e-9, 1e-9));
}

TEST(RobotTransforms, ALongDriveIsForgottenButForItsEnd) {
  const RobotTransforms transforms = driven(600.0);
  for (const double seconds : {550.0, 599.97}) {
    const msg::TFMessage message = transforms.at(at(seconds), kOnMap, {});
    EXPECT_TRUE(
        pose_near(pose_of(message.transforms.at(0)) * odom_T_robot(seconds), kOnMap, 2e-3, 1e-3));
  }
  // The oldest that is kept stands for what was before it.
  const msg::TFMessage message = transforms.at(at(1.0), kOnMap, {});
  EXPECT_FALSE(pose_near(pose_of(message.transforms.at(0)) * odom_T_robot(1.0), kOnMap, 1.0, 0.1));
}

TEST(PoseMessage, HasTheCovarianceInItsPlacesAmongSix) {
  Eigen::Matrix3d covariance;
  covariance << 1.0, 0.1, 0.2, 0.1, 2.0, 0.3, 0.2, 0.3, 3.0;
  const msg::PoseWithCovarianceStamped message = pose_message(at(2.0), kOnMap, covariance);
  EXPECT_EQ(message.header.frame_id, "map");
  const auto entry = [&](std::size_t row, std::size_t column) {
    return message.pose.covariance.at(6 * row + column);
  };
  EXPECT_EQ(entry(0, 0), 1.0);
  EXPECT_EQ(entry(1, 1), 2.0);
  EXPECT_EQ(entry(5, 5), 3.0);
  EXPECT_EQ(entry(0, 1), 0.1);
  EXPECT_EQ(entry(5, 0), 0.2);
  EXPECT_EQ(entry(1, 5), 0.3);
  EXPECT_EQ(entry(2, 2), 0.0);
}

TEST(InitialPoseOf, IsWhatThePoseMessageSays) {
  Eigen::Matrix3d covariance = Eigen::Vector3d(0.09, 0.16, 0.01).asDiagonal();
  const auto initial = initial_pose_of(pose_message(at(2.0), kOnMap, covariance));
  ASSERT_TRUE(initial);
  EXPECT_TRUE(pose_near(initial->map_T_robot, kOnMap, 1e-9, 1e-9));
  EXPECT_NEAR(initial->sigma_m, 0.4, 1e-12);
  EXPECT_NEAR(initial->sigma_rad, 0.1, 1e-12);
}

TEST(InitialPoseOf, WithoutCovarianceIsAsGoodAsOneGivenByHand) {
  const auto initial = initial_pose_of(pose_message(at(2.0), kOnMap, Eigen::Matrix3d::Zero()));
  ASSERT_TRUE(initial);
  EXPECT_EQ(initial->sigma_m, InitialPose{}.sigma_m);
  EXPECT_EQ(initial->sigma_rad, InitialPose{}.sigma_rad);
}

TEST(InitialPoseOf, WhatIsNoPoseIsNone) {
  msg::PoseWithCovarianceStamped message = pose_message(at(2.0), kOnMap, Eigen::Matrix3d::Zero());
  message.pose.pose.position.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(initial_pose_of(message));
  message = {};
  message.pose.pose.orientation = {.x = 0.0, .y = 0.0, .z = 0.0, .w = 0.0};
  EXPECT_FALSE(initial_pose_of(message));
}

TEST(DiagnosticsOf, TellWhatHoldsThePoseAndFaults) {
  MapUpdate update{.status = TrackingStatus::kLost};
  update.events.emplace_back(SubmapOpened{});
  update.events.emplace_back(LaserFaultChanged{});
  const auto told = diagnostics_of(update);
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[0].level, msg::DiagnosticStatus::kError);
  EXPECT_EQ(told[0].message, "lost");
  EXPECT_EQ(told[1].level, msg::DiagnosticStatus::kError);
}

TEST(DiagnosticsOf, TellHowFarALocaliserIsToBeTrusted) {
  const auto level = [](LocalizationState state) {
    return diagnostic_of(LocalizationEstimate{.state = state}).level;
  };
  EXPECT_EQ(level(LocalizationState::kTracking), msg::DiagnosticStatus::kOk);
  EXPECT_EQ(level(LocalizationState::kDoubtful), msg::DiagnosticStatus::kWarn);
  EXPECT_EQ(level(LocalizationState::kLost), msg::DiagnosticStatus::kError);
}

}  // namespace
}  // namespace loopstone
