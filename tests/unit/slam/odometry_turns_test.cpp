#include "loopstone/slam/odometry_turns.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "loopstone/base/rng.hpp"
#include "support/saved_state.hpp"

namespace loopstone {
namespace {

/// How a drive is told wrongly.
struct Told {
  double rad_per_m = 0.0;     ///< that odometry misses
  double rad_per_turn = 0.0;  ///< likewise
  double noise_rad = 0.002;   ///< of the laser, at each scan
  double slip_every_m = 0.0;
  double slip_rad = 0.08;
};

/// Steps of 5 cm, now to the left, now to the right; the laser's noise is of poses, not of motions.
void drive(OdometryTurns& turns, const Told& told, int steps, std::uint64_t seed) {
  Rng rng(seed);
  double noise_before = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double yaw = 0.04 * std::sin(0.02 * i);
    const double noise = told.noise_rad * rng.normal();
    double seen = yaw + told.rad_per_m * 0.05 + told.rad_per_turn * yaw + noise - noise_before;
    if (told.slip_every_m > 0.0 && rng.uniform() < 0.05 / told.slip_every_m)
      seen += told.slip_rad * (2.0 * rng.uniform() - 1.0);
    noise_before = noise;
    turns.add({0.05, yaw}, seen);
  }
}

TEST(OdometryTurns, NothingIsKnownAtFirst) {
  OdometryTurns turns;
  drive(turns, {.rad_per_m = 0.02}, 150, 1);
  EXPECT_EQ(turns.missed(), Eigen::Vector2d(0.0, 0.0));
  EXPECT_EQ(turns.sigma_rad({10.0, 0.0}), 0.0);
}

TEST(OdometryTurns, WhatIsMissedEachMetreAndEachRadianIsFoundApart) {
  OdometryTurns turns;
  drive(turns, {.rad_per_m = 0.007, .rad_per_turn = -0.03}, 2000, 2);
  EXPECT_NEAR(turns.missed().x(), 0.007, 0.0005);
  EXPECT_NEAR(turns.missed().y(), -0.03, 0.002);
}

TEST(OdometryTurns, SlipsAreOutliers) {
  OdometryTurns turns;
  drive(turns, {.rad_per_m = 0.01, .slip_every_m = 8.0}, 2000, 3);
  EXPECT_NEAR(turns.missed().x(), 0.01, 0.001);
}

TEST(OdometryTurns, OdometryThatIsRightIsLeftAsItIs) {
  int corrected = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    OdometryTurns turns;
    drive(turns, {.slip_every_m = 8.0}, 1000, seed);
    if (turns.missed() != Eigen::Vector2d(0.0, 0.0)) ++corrected;
  }
  EXPECT_LE(corrected, 1);
}

/// Errors of what is said of the next 20 m, beside their standard deviation.
TEST(OdometryTurns, StandardDeviationsAreHonest) {
  double sum = 0.0;
  const int drives = 200;
  const Eigen::Vector2d ahead(20.0, 2.0);
  for (std::uint64_t seed = 0; seed < drives; ++seed) {
    OdometryTurns turns;
    drive(turns, {.rad_per_m = 0.01, .rad_per_turn = 0.02, .slip_every_m = 8.0}, 1000, seed);
    const double off = (turns.missed() - Eigen::Vector2d(0.01, 0.02)).dot(ahead);
    sum += off * off / std::pow(turns.sigma_rad(ahead), 2);
  }
  EXPECT_GT(sum / drives, 0.2);
  EXPECT_LT(sum / drives, 2.0);
}

TEST(OdometryTurns, WhatIsLeftUncorrectedIsUncertain) {
  OdometryTurns turns;
  drive(turns, {.rad_per_m = 0.0008, .noise_rad = 0.0003}, 4000, 4);
  EXPECT_EQ(turns.missed(), Eigen::Vector2d(0.0, 0.0)) << "too small to matter";
  EXPECT_GT(turns.sigma_rad({50.0, 0.0}), 0.035);
}

TEST(OdometryTurns, WhatTheLaserDidNotSeeTeachesNothing) {
  OdometryTurns turns;
  for (int i = 0; i < 4000; ++i) {
    if (i % 5 == 0) turns.interrupt();
    turns.add({0.05, 0.0}, 0.01);
  }
  EXPECT_TRUE(turns.state().pieces.empty());
}

TEST(OdometryTurns, OldPiecesAreForgotten) {
  OdometryTurns turns;
  drive(turns, {.rad_per_m = 0.03}, 4000, 5);
  drive(turns, {.rad_per_m = -0.01}, 6000, 6);
  EXPECT_NEAR(turns.missed().x(), -0.01, 0.001);
}

TEST(OdometryTurns, GoesOnFromItsState) {
  OdometryTurns turns;
  drive(turns, {.rad_per_m = 0.01}, 1010, 7);
  OdometryTurns again = test::restored(turns, OdometryTurns{});
  EXPECT_EQ(again.missed(), turns.missed());
  EXPECT_EQ(again.sigma_rad({3.0, 1.0}), turns.sigma_rad({3.0, 1.0}));
  drive(turns, {.rad_per_m = 0.01}, 500, 8);
  drive(again, {.rad_per_m = 0.01}, 500, 8);
  EXPECT_EQ(test::state_of(again), test::state_of(turns));
  EXPECT_TRUE(test::refuses(turns, [](auto& state) { state.pieces.resize(321); }));
  EXPECT_TRUE(test::refuses(turns, [](auto& state) { state.pieces[3].missed_rad = std::nan(""); }));
  EXPECT_TRUE(
      test::refuses(turns, [](auto& state) { state.open.way_and_turn.x() = std::nan(""); }));
}

}  // namespace
}  // namespace loopstone
