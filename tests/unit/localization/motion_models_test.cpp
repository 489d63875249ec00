#include "loopstone/localization/motion_models.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <functional>
#include <vector>

#include "support/generators.hpp"
#include "support/pose_near.hpp"

namespace loopstone::test {
namespace {

struct Moments {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// Of (x, y, yaw) about a pose, over many samples.
Moments moments_of(const std::function<Pose2(Rng&)>& sample, const Pose2& about) {
  constexpr int kSamples = 20000;
  Rng rng(5);
  std::vector<Eigen::Vector3d> values;
  Moments moments;
  for (int i = 0; i < kSamples; ++i) {
    const Pose2 pose = sample(rng);
    values.push_back({pose.x - about.x, pose.y - about.y, wrap_angle(pose.yaw - about.yaw)});
    moments.mean += values.back() / kSamples;
  }
  for (const auto& value : values) {
    const Eigen::Vector3d off = value - moments.mean;
    moments.covariance += off * off.transpose() / (kSamples - 1);
  }
  return moments;
}

RC_GTEST_PROP(MotionModels, TurnsAndWayMakeTheMotionAgain, ()) {
  const Pose2 motion{*between(-3.0, 3.0), *between(-3.0, 3.0), *between(-3.1, 3.1)};
  const TurnGoTurn parts = turn_go_turn(motion);
  RC_ASSERT(std::abs(parts.first_turn_rad) <= kPi / 2.0 + 1e-12);
  const Pose2 again = to_pose(parts);
  RC_ASSERT(std::abs(again.x - motion.x) < 1e-12);
  RC_ASSERT(std::abs(again.y - motion.y) < 1e-12);
  RC_ASSERT(std::abs(wrap_angle(again.yaw - motion.yaw)) < 1e-12);
}

RC_GTEST_PROP(MotionModels, WithoutNoiseAllModelsFollowTheMotion, ()) {
  const Pose2 start{*between(-3.0, 3.0), *between(-3.0, 3.0), *between(-3.1, 3.1)};
  const double speed = *between(-1.0, 1.0);
  const double rate = *between(-1.0, 1.0);
  const double duration = *between(0.01, 2.0);
  const Pose2 motion = exp(Tangent2{speed * duration, 0.0, rate * duration});
  const Pose2 expected = start * motion;
  Rng rng(1);
  const OdometryMotionNoise still{0.0, 0.0, 0.0, 0.0};
  const VelocityMotionNoise steady{0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  const GaussianMotion sure(motion, Eigen::Matrix3d::Zero());
  for (const Pose2& pose : {sample_odometry_motion(start, turn_go_turn(motion), still, rng),
                            sample_velocity_motion(start, speed, rate, duration, steady, rng),
                            sure.sample(start, rng)}) {
    RC_ASSERT(std::hypot(pose.x - expected.x, pose.y - expected.y) < 1e-9);
    RC_ASSERT(std::abs(wrap_angle(pose.yaw - expected.yaw)) < 1e-9);
  }
}

TEST(MotionModels, OdometryNoiseHasTheSpreadOfItsFactors) {
  const OdometryMotionNoise noise{.turn_from_turn = 0.1,
                                  .turn_from_travel = 0.02,
                                  .travel_from_travel = 0.05,
                                  .travel_from_turn = 0.0};
  const TurnGoTurn motion{0.0, 2.0, 0.5};
  const Moments moments = moments_of(
      [&](Rng& rng) { return sample_odometry_motion({}, motion, noise, rng); }, to_pose(motion));
  // Along: 0.05 * 2 m. Across: the first turn's 0.02 * 2 rad over 2 m. Heading: both turns.
  EXPECT_NEAR(std::sqrt(moments.covariance(0, 0)), 0.1, 0.004);
  EXPECT_NEAR(std::sqrt(moments.covariance(1, 1)), 0.08, 0.004);
  EXPECT_NEAR(std::sqrt(moments.covariance(2, 2)), std::hypot(0.04, std::hypot(0.05, 0.04)), 0.003);
}

TEST(MotionModels, ATurnOnTheSpotIsOneTurn) {
  // Odometry that trembles by a millimetre says nothing about the direction of travel.
  const OdometryMotionNoise noise{.turn_from_turn = 0.1,
                                  .turn_from_travel = 0.0,
                                  .travel_from_travel = 0.0,
                                  .travel_from_turn = 0.0};
  const Pose2 motion{0.0, 0.001, 0.4};
  const Moments moments = moments_of(
      [&](Rng& rng) { return sample_odometry_motion({}, turn_go_turn(motion), noise, rng); },
      motion);
  EXPECT_NEAR(std::sqrt(moments.covariance(2, 2)), 0.04, 0.002);
}

TEST(MotionModels, DrivingBackwardsIsNoTurn) {
  const TurnGoTurn motion = turn_go_turn({-1.0, 0.0, 0.0});
  EXPECT_NEAR(motion.first_turn_rad, 0.0, 1e-12);
  EXPECT_NEAR(motion.travel_m, -1.0, 1e-12);
}

TEST(MotionModels, VelocityNoiseHasTheSpreadOfItsFactors) {
  const VelocityMotionNoise noise{.speed_from_speed = 0.1,
                                  .speed_from_rate = 0.0,
                                  .rate_from_speed = 0.0,
                                  .rate_from_rate = 0.0,
                                  .turn_from_speed = 0.05,
                                  .turn_from_rate = 0.0};
  const Moments moments =
      moments_of([&](Rng& rng) { return sample_velocity_motion({}, 0.5, 0.0, 2.0, noise, rng); },
                 {1.0, 0.0, 0.0});
  EXPECT_NEAR(std::sqrt(moments.covariance(0, 0)), 0.1, 0.004);
  EXPECT_NEAR(moments.covariance(1, 1), 0.0, 1e-12);
  EXPECT_NEAR(std::sqrt(moments.covariance(2, 2)), 0.05, 0.002);
}

TEST(MotionModels, GaussianMotionHasItsCovariance) {
  Eigen::Matrix3d covariance;
  covariance << 0.04, 0.01, 0.002, 0.01, 0.02, -0.001, 0.002, -0.001, 0.003;
  const Pose2 mean{0.3, -0.1, 0.2};
  const GaussianMotion motion(mean, covariance);
  const Moments moments = moments_of([&](Rng& rng) { return motion.sample({}, rng); }, mean);
  EXPECT_LT((moments.covariance - covariance).cwiseAbs().maxCoeff(), 0.0015);
  EXPECT_LT(moments.mean.norm(), 0.005);
  // A corridor's covariance is singular across: a root exists all the same.
  Eigen::Matrix3d flat = Eigen::Matrix3d::Zero();
  flat(0, 0) = 0.25;
  const Eigen::Matrix3d root = square_root(flat);
  EXPECT_LT((root * root.transpose() - flat).norm(), 1e-12);
}

}  // namespace
}  // namespace loopstone::test
