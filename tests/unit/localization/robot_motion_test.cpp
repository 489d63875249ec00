#include "localization/robot_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/pose_near.hpp"

namespace loopstone {
namespace {

/// How far particles scatter about where a metre straight ahead leads.
double scatter_m(const LocalizationOptions& options) {
  Odometer odometer{WheelModel{}};
  for (int i = 0; i <= 10; ++i) {
    odometer.add(OdometryPose{Stamp{1'000'000'000LL + i * 100'000'000LL}, {0.1 * i, 0.0, 0.0}});
  }
  RobotMotion motion(options);
  (void)motion.step_to(Stamp{1'000'000'000LL}, odometer);
  (void)motion.step_to(Stamp{2'000'000'000LL}, odometer);
  EXPECT_TRUE(test::pose_near(motion.since_weighing().pose, {1.0, 0.0, 0.0}, 1e-9, 1e-9));
  constexpr int kSamples = 500;
  Rng rng(3);
  const auto sample = motion.sampler({});
  double squared_m2 = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const Pose2 pose = sample({}, rng);
    squared_m2 += std::pow(pose.x - 1.0, 2) + std::pow(pose.y, 2);
  }
  return std::sqrt(squared_m2 / kSamples);
}

TEST(RobotMotion, NoiseOfTheModelsIsAnOption) {
  LocalizationOptions options{.motion = ParticleMotion::kOdometry};
  EXPECT_GT(scatter_m(options), 0.02);
  options.odometry_noise = {0.0, 0.0, 0.0, 0.0};
  EXPECT_LT(scatter_m(options), 1e-9);

  options = {.motion = ParticleMotion::kVelocity};
  EXPECT_GT(scatter_m(options), 0.02);
  options.velocity_noise = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  EXPECT_LT(scatter_m(options), 1e-9);
}

TEST(RobotMotion, NoiseOfAModelMattersToNoOther) {
  const LocalizationOptions usual{};
  LocalizationOptions other{};
  other.odometry_noise = {1.0, 1.0, 1.0, 1.0};
  other.velocity_noise = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
  EXPECT_EQ(scatter_m(usual), scatter_m(other));
}

Stamp at(double seconds) { return Stamp::from_seconds(100.0 + seconds); }

/// Odometry that stands while the robot drives.
Odometer standing() {
  Odometer odometer{WheelModel{}};
  for (int i = 0; i <= 20; ++i) odometer.add(OdometryPose{at(0.1 * i), {0.0, 0.0, 0.02 * i}});
  return odometer;
}

TEST(RobotMotion, PartsThatAreNotTrustedComeFromWhereTheRobotWasFound) {
  const Odometer odometer = standing();
  RobotMotion motion(LocalizationOptions{});
  const RobotMotion::Trust heading_alone{.translation = false, .rotation = true};
  for (int i = 0; i <= 10; ++i) {
    (void)motion.step_to(at(0.1 * i), odometer, heading_alone);
    motion.found_at({0.07 * i, 0.0, 0.0});
  }
  const PoseWithCovariance2 step = motion.step_to(at(1.1), odometer, heading_alone);
  EXPECT_TRUE(test::pose_near(step.pose, {0.07, 0.0, 0.02}, 1e-9, 1e-9));
  EXPECT_FALSE(motion.is_told());
  EXPECT_GT(step.covariance(0, 0), 0.03 * 0.03) << "a guess";
  EXPECT_LT(step.covariance(2, 2), 0.03 * 0.03) << "odometry's";
  const PoseWithCovariance2 trusted = motion.step_to(at(1.2), odometer);
  EXPECT_TRUE(test::pose_near(trusted.pose, {0.0, 0.0, 0.02}, 1e-9, 1e-9));
  EXPECT_TRUE(motion.is_told());
}

TEST(RobotMotion, ARobotThatWasFoundElsewhereDidNotDriveThere) {
  const Odometer odometer = standing();
  const RobotMotion::Trust nothing{.translation = false, .rotation = false};
  RobotMotion motion(LocalizationOptions{});
  for (int i = 0; i <= 5; ++i) {
    (void)motion.step_to(at(0.1 * i), odometer, nothing);
    motion.found_at({0.07 * i, 0.0, 0.0});
  }
  (void)motion.step_to(at(0.6), odometer, nothing);
  motion.found_at({30.0, 5.0, 2.0});
  const PoseWithCovariance2 step = motion.step_to(at(0.7), odometer, nothing);
  EXPECT_TRUE(test::pose_near(step.pose, {0.07, 0.0, 0.0}, 1e-9, 1e-9));
}

}  // namespace
}  // namespace loopstone
