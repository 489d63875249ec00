#include "slam/path_drift.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <deque>
#include <vector>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

Eigen::Matrix3d match_covariance(double along_m, double across_m, double heading_rad,
                                 double axis_rad = 0.0) {
  const Eigen::Matrix3d covariance =
      Eigen::Vector3d(along_m * along_m, across_m * across_m, heading_rad * heading_rad)
          .asDiagonal();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Pose2{0.0, 0.0, axis_rad}.rotation();
  return turn * covariance * turn.transpose();
}

KeyScan key_at(const Pose2& pose, const Eigen::Matrix3d& covariance, std::size_t scan = 0) {
  KeyScan key;
  key.local_T_robot = pose;
  key.covariance = covariance;
  key.scan = scan;
  return key;
}

TEST(PathDrift, TheNoiseOfAMatchDoesNotAddUp) {
  const auto previous = key_at({}, match_covariance(0.004, 0.004, 0.001));
  const auto next = key_at({0.3, 0.0, 0.0}, match_covariance(0.004, 0.004, 0.001));
  const StepDrift drift = drift_between(previous, next, Pose2{0.3, 0.0, 0.0});
  EXPECT_FALSE(drift.open);
  const double sigma = kPathDrift.rest_m + kPathDrift.travel_share * 0.3;
  EXPECT_NEAR(std::sqrt(drift.covariance(0, 0)), sigma, 1e-9);
  EXPECT_NEAR(std::sqrt(drift.covariance(2, 2)), kPathDrift.rest_rad, 1e-9);
}

TEST(PathDrift, AlongACorridorOdometrysErrorsAddUp) {
  for (const double axis : {0.0, 0.9, 2.0}) {
    const Pose2 motion = Pose2{0.0, 0.0, axis} * Pose2{0.3, 0.0, 0.0};
    const auto previous = key_at({0.0, 0.0, axis}, match_covariance(0.012, 0.004, 0.001, axis));
    const auto next =
        key_at({motion.x, motion.y, axis}, match_covariance(0.012, 0.004, 0.001, axis));
    const StepDrift known = drift_between(previous, next, Pose2{0.3, 0.0, 0.0});
    const StepDrift unknown = drift_between(previous, next, {});
    const StepDrift off = drift_between(previous, next, Pose2{0.305, 0.4, 0.0});
    EXPECT_TRUE(known.open);
    const double rest = kPathDrift.rest_m + kPathDrift.travel_share * 0.3;
    // On the robot's axes, whichever way the corridor leads.
    EXPECT_NEAR(known.covariance(0, 0), std::pow(kPathDrift.walk_m, 2) * 0.3 + rest * rest, 1e-9);
    EXPECT_NEAR(known.covariance(1, 1), rest * rest, 1e-9);
    EXPECT_NEAR(off.covariance(0, 0) - known.covariance(0, 0), 0.005 * 0.005, 1e-9);
    EXPECT_NEAR(unknown.covariance(0, 0), 0.012 * 0.012 - 0.004 * 0.004 + rest * rest, 1e-9);
  }
}

TEST(PathDrift, WhatNobodyHeldDriftsAsFarAsItWasGranted) {
  const auto previous = key_at({}, match_covariance(0.004, 0.004, 0.001));
  auto next = key_at({4.0, 0.0, 0.0}, match_covariance(0.004, 0.004, 0.001));
  next.across = match_covariance(0.5, 0.3, 0.1);
  const StepDrift drift = drift_between(previous, next, Pose2{4.0, 0.0, 0.0});
  EXPECT_NEAR(std::sqrt(drift.covariance(0, 0)), 0.5, 1e-3);
  EXPECT_NEAR(std::sqrt(drift.covariance(2, 2)), 0.1, 1e-3);
}

TEST(PathDrift, CorridorsDrivenBeforeTheScaleWasKnownAreTooLong) {
  std::vector<KeyScan> keys;
  std::deque<TrackedPose> track;
  const Eigen::Matrix3d open = match_covariance(0.012, 0.004, 0.001);
  const Eigen::Matrix3d held = match_covariance(0.004, 0.004, 0.001);
  // 10 m of a corridor by odometry that counts 2 % too far, then 10 m that the laser holds.
  for (std::size_t i = 0; i <= 20; ++i) {
    const double odom_m = 1.02 * static_cast<double>(i);
    const double local_m = i <= 10 ? odom_m : 10.2 + static_cast<double>(i - 10);
    keys.push_back(key_at({local_m, 0.0, 0.0}, i <= 10 ? open : held, i));
    keys.back().stamp = Stamp::from_seconds(static_cast<double>(i));
    track.push_back({Stamp::from_seconds(static_cast<double>(i)), keys.back().local_T_robot,
                     Pose2{odom_m, 0.0, 0.0}});
  }
  EXPECT_NEAR(open_travel_error_m(keys, {track, 1.02}), 0.2, 1e-9);
  EXPECT_NEAR(open_travel_error_m(keys, {track, 1.0}), 0.0, 1e-9);
  // What it says of a break may be hearsay.
  const std::vector<PathBreak> breaks{
      {.from = Stamp::from_seconds(3.2), .to = Stamp::from_seconds(4.9)}};
  EXPECT_NEAR(open_travel_error_m(keys, {track, 1.02, breaks}), 0.16, 1e-9);
  for (TrackedPose& pose : track) pose.odom_T_robot.reset();
  EXPECT_EQ(open_travel_error_m(keys, {track, 1.02}), 0.0) << "without odometry nothing is known";
}

}  // namespace
}  // namespace loopstone
