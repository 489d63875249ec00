#include "localization/observation_window.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "landmark_scene.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

using test::hall_map;
using test::seen_from;

PoseWithCovariance2 moved(double sigma_m, double sigma_rad) {
  return test::about({0.5, 0.1, 0.3}, sigma_m, sigma_rad);
}

TEST(ObservationWindow, WhatWasSeenIsWhereItWouldBeSeenNow) {
  const LandmarkMap map = hall_map();
  Rng rng(1);
  const Pose2 before{1.0, 2.0, 0.4};
  ObservationWindow window;
  window.add(seen_from(before, map, {0, 3}, false, rng, 0.0));
  window.move(moved(0.0, 0.0));
  const auto now = seen_from(before * moved(0.0, 0.0).pose, map, {0, 3}, false, rng, 0.0);
  ASSERT_EQ(window.observations().size(), 2U);
  for (std::size_t i = 0; i < now.size(); ++i) {
    EXPECT_LT((window.observations()[i].point - now[i].point).norm(), 1e-12);
    EXPECT_LT((window.observations()[i].direction.norm() - 1.0), 1e-12);
  }
}

TEST(ObservationWindow, MotionMakesItLessCertainAsSamplesShow) {
  const LandmarkMap map = hall_map();
  Rng rng(2);
  ObservationWindow window;
  window.add(seen_from({}, map, {1}, false, rng, 0.0));
  const LandmarkObservation before = window.observations()[0];
  const PoseWithCovariance2 motion = moved(0.05, 0.02);
  window.move(motion);
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  constexpr int kSamples = 20000;
  const Eigen::Matrix2d root = before.covariance.llt().matrixL();
  for (int i = 0; i < kSamples; ++i) {
    const Pose2 drawn{motion.pose.x + rng.normal(0.0, 0.05), motion.pose.y + rng.normal(0.0, 0.05),
                      motion.pose.yaw + rng.normal(0.0, 0.02)};
    const Eigen::Vector2d point =
        before.point + root * Eigen::Vector2d(rng.normal(0.0, 1.0), rng.normal(0.0, 1.0));
    const Eigen::Vector2d off = drawn.inverse() * point - window.observations()[0].point;
    spread += off * off.transpose() / kSamples;
  }
  EXPECT_LT((spread - window.observations()[0].covariance).norm(), 0.05 * spread.norm());
}

TEST(ObservationWindow, SeenAgainReplacesAndUncertainGoes) {
  const LandmarkMap map = hall_map();
  Rng rng(3);
  ObservationWindow window;
  window.add(seen_from({}, map, {0, 1}, false, rng));
  window.add(seen_from({}, map, {1, 2}, false, rng));
  EXPECT_EQ(window.observations().size(), 3U);
  window.add(seen_from({}, map, {4}, true, rng));
  window.add(seen_from({0.0, 0.0, 1.0}, map, {4}, true, rng));
  EXPECT_EQ(window.observations().size(), 4U) << "a name is one landmark, wherever it seems to be";
  for (int i = 0; i < 10; ++i) window.move(moved(0.3, 0.05));
  EXPECT_TRUE(window.observations().empty());
}

TEST(ObservationWindow, WhatWasSeenIsExpectedAgainWhereItWas) {
  ObservationWindow window;
  constexpr double kAnywhere = -8.0;
  const std::vector first{observed(3.0, 0.2, 0.02, 0.004)};
  EXPECT_FALSE(window.expectations(first, kAnywhere)[0].is_seen_before);
  EXPECT_EQ(window.expectations(first, kAnywhere)[0].log_density, kAnywhere);
  window.add(first);
  const auto again = window.expectations(
      {observed(3.0, 0.2, 0.02, 0.004), observed(4.0, 0.2, 0.02, 0.004)}, kAnywhere);
  EXPECT_TRUE(again[0].is_seen_before);
  // The normal density at its middle, of both spreads together.
  const double sigmas = 2.0 * 0.02 * 3.0 * 0.004;
  EXPECT_NEAR(again[0].log_density, std::log(0.9 / (2.0 * kPi * sigmas)), 1e-9);
  EXPECT_FALSE(again[1].is_seen_before);
  window.clear();
  EXPECT_TRUE(window.observations().empty());
}

TEST(ObservationWindow, KeepsTheNewest) {
  ObservationWindow window;
  for (int i = 0; i < 30; ++i) window.add({observed(1.0 + 0.5 * i, 0.0, 0.01, 0.001)});
  EXPECT_EQ(window.observations().size(), 16U);
  EXPECT_NEAR(window.observations().back().point.x(), 1.0 + 0.5 * 29, 1e-12);
}

}  // namespace
}  // namespace loopstone
