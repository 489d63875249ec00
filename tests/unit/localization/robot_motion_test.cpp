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

}  // namespace
}  // namespace loopstone
