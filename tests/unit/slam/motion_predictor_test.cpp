#include "loopstone/slam/motion_predictor.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::pose_near;

Stamp stamp_at(double seconds) { return Stamp::from_seconds(10.0 + seconds); }
const Pose2 kStep = exp(Tangent2(0.05, 0.0, 0.02));

/// A predictor after ten scans of a steady drive, and where the robot is then.
struct Driven {
  MotionPredictor predictor;
  Pose2 local_T_robot{};
  double seconds = 0.0;
};

Driven drive(bool with_odometry, bool has_translation = true, bool check = true) {
  Driven driven{MotionPredictor(check)};
  for (int i = 0; i < 10; ++i) {
    if (i > 0) {
      driven.local_T_robot = driven.local_T_robot * kStep;
      driven.seconds += 0.1;
    }
    std::optional<OdometryReading> odometry;
    if (with_odometry) odometry = OdometryReading{driven.local_T_robot, has_translation};
    driven.predictor.settle(stamp_at(driven.seconds), driven.local_T_robot, odometry, {true, true});
  }
  return driven;
}

TEST(MotionPredictor, MotionGoesOnWithoutOdometry) {
  const Driven driven = drive(false);
  const auto guesses = driven.predictor.guesses(stamp_at(driven.seconds + 0.1), {});
  ASSERT_EQ(guesses.size(), 1u);
  EXPECT_TRUE(pose_near(guesses[0].local_T_robot, driven.local_T_robot * kStep, 1e-9, 1e-9));
  EXPECT_FALSE(guesses[0].measured);
}

TEST(MotionPredictor, ARobotIsAsFastAsItHasShown) {
  MotionPredictor predictor;
  EXPECT_EQ(predictor.fastest_m_s(), kMotionPredictor.walking_m_s) << "nothing is known";
  EXPECT_EQ(predictor.fastest_back_m_s(), kMotionPredictor.walking_m_s);
  EXPECT_EQ(predictor.fastest_rad_s(), kMotionPredictor.walking_rad_s);
  Pose2 local_T_robot;
  double seconds = 0.0;
  const auto drive_on = [&](double metres_a_second, double radians_a_second, int scans) {
    for (int i = 0; i < scans; ++i) {
      seconds += 0.1;
      local_T_robot =
          local_T_robot * exp(Tangent2(0.1 * metres_a_second, 0.0, 0.1 * radians_a_second));
      predictor.settle(stamp_at(seconds), local_T_robot, {}, {true, true});
    }
  };
  drive_on(0.5, 0.2, 300);
  const double margin = kMotionPredictor.speed_margin;
  EXPECT_NEAR(predictor.fastest_m_s(), margin * 0.5, 0.01);
  EXPECT_EQ(predictor.fastest_rad_s(), kMotionPredictor.slowest_rad_s);
  EXPECT_NEAR(predictor.fastest_back_m_s(), 0.0, 1e-9) << "it never drove backwards";
  drive_on(-0.4, 1.5, 100);
  EXPECT_NEAR(predictor.fastest_m_s(), margin * 0.5, 0.01) << "the fastest counts";
  EXPECT_NEAR(predictor.fastest_back_m_s(), margin * 0.4, 0.01);
  EXPECT_NEAR(predictor.fastest_rad_s(), margin * 1.5, 0.01);
  // One leap of a laser that was mistaken counts half.
  drive_on(0.5, 0.0, 30);
  local_T_robot = local_T_robot * Pose2{3.0, 0.0, 0.0};
  drive_on(0.5, 0.0, 10);
  EXPECT_LT(predictor.fastest_m_s(), margin * 2.1);
}

TEST(MotionPredictor, AMissingScanLeavesTwoGuesses) {
  const Driven driven = drive(false);
  const auto guesses = driven.predictor.guesses(stamp_at(driven.seconds + 0.3), {});
  ASSERT_EQ(guesses.size(), 2u);
  EXPECT_TRUE(pose_near(guesses[0].local_T_robot, driven.local_T_robot * kStep, 1e-9, 1e-9));
  EXPECT_TRUE(pose_near(guesses[1].local_T_robot, driven.local_T_robot * kStep * kStep * kStep,
                        1e-6, 1e-6));
}

TEST(MotionPredictor, OdometryComesFirstAndAloneWhereItIsPlausible) {
  const Driven driven = drive(true);
  const Pose2 motion{0.06, 0.0, -0.01};
  const auto guesses = driven.predictor.guesses(stamp_at(driven.seconds + 0.1),
                                                OdometryReading{driven.local_T_robot * motion});
  ASSERT_EQ(guesses.size(), 1u);
  EXPECT_TRUE(pose_near(guesses[0].local_T_robot, driven.local_T_robot * motion, 1e-9, 1e-9));
  EXPECT_TRUE(guesses[0].measured);
}

TEST(MotionPredictor, OdometryThatJumpsIsOneOfTwoGuesses) {
  const Driven driven = drive(true);
  const auto guesses = driven.predictor.guesses(
      stamp_at(driven.seconds + 0.1), OdometryReading{driven.local_T_robot * Pose2{1.0, 0.0, 0.5}});
  ASSERT_EQ(guesses.size(), 2u);
  EXPECT_TRUE(guesses[0].measured);
  EXPECT_FALSE(guesses[1].measured);
  EXPECT_TRUE(pose_near(guesses[1].local_T_robot, driven.local_T_robot * kStep, 1e-9, 1e-9));
}

TEST(MotionPredictor, AGyroTellsTheHeadingAndTheDistanceGoesOn) {
  const Driven driven = drive(true, false);
  Pose2 heading = driven.local_T_robot;
  heading.yaw += 0.11;
  const auto guesses =
      driven.predictor.guesses(stamp_at(driven.seconds + 0.1), OdometryReading{heading, false});
  ASSERT_EQ(guesses.size(), 1u);
  const Pose2 motion = driven.local_T_robot.inverse() * guesses[0].local_T_robot;
  EXPECT_NEAR(motion.yaw, 0.11, 1e-9);
  EXPECT_NEAR(motion.x, kStep.x, 1e-9);
  EXPECT_FALSE(guesses[0].measured);
  const double coast_rad = driven.predictor.coast_sigma_rad();
  EXPECT_GT(guesses[0].information(2, 2), 2.0 / (coast_rad * coast_rad));
}

TEST(MotionPredictor, ReadingsOfDifferentKindsAreNotCompared) {
  const Driven driven = drive(true, false);
  const auto guesses = driven.predictor.guesses(stamp_at(driven.seconds + 0.1),
                                                OdometryReading{Pose2{7.0, 8.0, 3.0}, true});
  ASSERT_EQ(guesses.size(), 1u);
  EXPECT_TRUE(pose_near(guesses[0].local_T_robot, driven.local_T_robot * kStep, 1e-9, 1e-9));
}

/// The robot drives steadily, its wheels stand still.
Pose2 guess_with_stuck_wheels(bool check) {
  MotionPredictor predictor(check);
  Pose2 local_T_robot;
  for (int i = 0; i < 300; ++i) {
    if (i > 0) local_T_robot = local_T_robot * kStep;
    predictor.settle(stamp_at(0.1 * i), local_T_robot, OdometryReading{}, {true, true});
  }
  const auto guesses = predictor.guesses(stamp_at(30.0), OdometryReading{});
  return local_T_robot.inverse() * guesses.front().local_T_robot;
}

TEST(MotionPredictor, WheelsThatWereFoundWrongAreNotAsked) {
  EXPECT_TRUE(pose_near(guess_with_stuck_wheels(true), kStep, 1e-9, 1e-9));
  EXPECT_TRUE(pose_near(guess_with_stuck_wheels(false), Pose2{}, 1e-9, 1e-9)) << "trusted as asked";
}

/// The robot drives steadily, and wheels say something else; then the laser is blind for so long,
/// and each scan stands where it is guessed. The motion that is guessed next.
Pose2 guess_of_the_blind(const Pose2& said, double blind_s) {
  MotionPredictor predictor;
  Pose2 local_T_robot;
  OdometryReading odometry;
  int scan = 0;
  const auto take = [&] {
    odometry.odom_T_robot = odometry.odom_T_robot * said;
    odometry.path_m += std::hypot(said.x, said.y);
    return stamp_at(0.1 * ++scan);
  };
  while (scan < 300) {
    const Stamp stamp = take();
    local_T_robot = local_T_robot * kStep;
    predictor.settle(stamp, local_T_robot, odometry, {true, true});
  }
  while (scan < 300 + static_cast<int>(10.0 * blind_s)) {
    const Stamp stamp = take();
    local_T_robot = predictor.guesses(stamp, odometry).front().local_T_robot;
    predictor.settle(stamp, local_T_robot, odometry, {false, false});
  }
  const Stamp stamp = take();
  return local_T_robot.inverse() * predictor.guesses(stamp, odometry).front().local_T_robot;
}

TEST(MotionPredictor, ABlindRobotDoesNotGoOnForEver) {
  EXPECT_TRUE(pose_near(guess_of_the_blind(Pose2{}, 1.0), kStep, 1e-9, 1e-9)) << "a moment";
  EXPECT_TRUE(pose_near(guess_of_the_blind(Pose2{}, 10.0), Pose2{}, 1e-9, 1e-9));
  const Pose2 doubled{2.0 * kStep.x, 2.0 * kStep.y, kStep.yaw};
  EXPECT_TRUE(pose_near(guess_of_the_blind(doubled, 10.0), kStep, 1e-3, 1e-3))
      << "wheels that are wrong by a factor";
  const Pose2 right{kStep.x, kStep.y, kStep.yaw};
  EXPECT_TRUE(pose_near(guess_of_the_blind(right, 10.0), kStep, 1e-6, 1e-6));
}

TEST(MotionPredictor, WheelsThatAreTooLargeAreCorrected) {
  MotionPredictor predictor;
  Pose2 local_T_robot;
  Pose2 odom_T_robot;
  const Pose2 said{1.04 * kStep.x, 1.04 * kStep.y, kStep.yaw};
  for (int i = 0; i < 300; ++i) {
    if (i > 0) {
      local_T_robot = local_T_robot * kStep;
      odom_T_robot = odom_T_robot * said;
    }
    predictor.settle(stamp_at(0.1 * i), local_T_robot, OdometryReading{odom_T_robot}, {true, true});
  }
  const auto guesses = predictor.guesses(stamp_at(30.0), OdometryReading{odom_T_robot * said});
  EXPECT_TRUE(pose_near(guesses.front().local_T_robot, local_T_robot * kStep, 1e-4, 1e-9));
}

/// A robot that drives 30 m, while odometry misses 0.02 rad of each metre.
struct Veering {
  MotionPredictor predictor;
  Pose2 local_T_robot{};
  OdometryReading odometry{};
  double seconds = 0.0;

  void step(const Pose2& said, bool is_seen) {
    local_T_robot = local_T_robot * exp(Tangent2(log(said) + Tangent2(0.0, 0.0, 0.02 * said.x)));
    odometry.odom_T_robot = odometry.odom_T_robot * said;
    odometry.path_m += said.x;
    seconds += 0.1;
    settle(is_seen);
  }
  void settle(bool is_seen) {
    const auto guesses = predictor.guesses(stamp_at(seconds), odometry);
    const Pose2 settled = is_seen ? local_T_robot : guesses.front().local_T_robot;
    predictor.settle(stamp_at(seconds), settled, odometry, {is_seen, is_seen});
  }
};

Veering drive_veering() {
  Veering drive;
  drive.settle(true);
  for (int i = 0; i < 600; ++i)
    drive.step(exp(Tangent2(0.05, 0.0, 0.01 * std::sin(0.1 * i))), true);
  return drive;
}

TEST(MotionPredictor, WheelsOfUnequalSizeAreCorrected) {
  Veering drive = drive_veering();
  OdometryReading next = drive.odometry;
  next.odom_T_robot = next.odom_T_robot * Pose2{0.05, 0.0, 0.0};
  next.path_m += 0.05;
  const auto guesses = drive.predictor.guesses(stamp_at(drive.seconds + 0.1), next);
  EXPECT_TRUE(pose_near(guesses.front().local_T_robot,
                        drive.local_T_robot * exp(Tangent2(0.05, 0.0, 0.001)), 1e-4, 1e-5));
}

TEST(MotionPredictor, WhereTheLaserIsBlindOdometryIsCorrectedFromScanToScan) {
  Veering drive = drive_veering();
  const Veering before = drive;
  for (int i = 0; i < 300; ++i) drive.step(exp(Tangent2(0.05, 0.0, i < 150 ? 0.0 : 0.01)), false);
  const auto told = drive.predictor.told(before.odometry, stamp_at(before.seconds), drive.odometry);
  ASSERT_TRUE(told);
  const Pose2 truth = before.local_T_robot.inverse() * drive.local_T_robot;
  EXPECT_TRUE(pose_near(told->motion, truth, 0.01, 0.002));
  EXPECT_LT(told->sigma_rad, 0.16) << "no more than the best wheels, and their turns";
  // Nothing came between: the turns missed are spread along an arc, which the way was not.
  const auto across =
      before.predictor.told(before.odometry, stamp_at(before.seconds), drive.odometry);
  ASSERT_TRUE(across);
  EXPECT_TRUE(pose_near(across->motion, truth, 0.1, 0.03)) << "of 0.3 rad that odometry missed";
}

TEST(MotionPredictor, UncertaintyIsLearnedFromHowTheRobotMoves) {
  MotionPredictor calm;
  MotionPredictor wild;
  Pose2 steady;
  Pose2 turned;
  for (int i = 0; i < 200; ++i) {
    steady = steady * kStep;
    turned = turned * Pose2{0.0, 0.0, i % 4 < 2 ? 0.4 : -0.4};
    calm.settle(stamp_at(0.1 * i), steady, {}, {true, true});
    wild.settle(stamp_at(0.1 * i), turned, {}, {true, true});
  }
  EXPECT_LT(calm.coast_sigma_rad(), 0.06);
  EXPECT_GT(wild.coast_sigma_rad(), 0.2);
}

/// After 40 m straight on; odometry veers by so much, now to the left and now to the right.
MotionPredictor after_veering(double rad_per_m) {
  MotionPredictor predictor;
  double said_yaw = 0.0;
  for (int i = 0; i <= 400; ++i) {
    const double x = 0.1 * i;
    said_yaw += ((i / 50) % 2 == 0 ? 0.1 : -0.1) * rad_per_m;
    OdometryReading odometry{Pose2{x, 0.0, said_yaw}};
    odometry.path_m = x;
    predictor.settle(stamp_at(x), Pose2{x, 0.0, 0.0}, odometry, {true, true});
  }
  return predictor;
}

TEST(MotionPredictor, AHeadingThatProvedSteadyIsTrustedMore) {
  EXPECT_FALSE(MotionPredictor{}.heading_is_steady()) << "nothing is known";
  const MotionPredictor steady = after_veering(0.0003);
  const MotionPredictor veering = after_veering(0.005);
  EXPECT_TRUE(steady.heading_is_steady());
  EXPECT_FALSE(veering.heading_is_steady());
  OdometryReading next{Pose2{40.1, 0.0, 0.0}};
  next.path_m = 40.1;
  const auto sigma_rad = [&](const MotionPredictor& predictor) {
    const auto guesses = predictor.guesses(stamp_at(40.1), next);
    return 1.0 / std::sqrt(guesses.front().information(2, 2));
  };
  EXPECT_LT(sigma_rad(steady), 0.75 * sigma_rad(veering));
  EXPECT_GE(sigma_rad(steady), kMotionPredictor.steady_rest_rad);
}

TEST(MotionPredictor, WhatOdometrySaysAcrossASilenceIsNotAsked) {
  Driven driven = drive(true);
  OdometryReading odometry{driven.local_T_robot};  // its counts of the last step were lost
  odometry.silent_until = stamp_at(driven.seconds + 0.05);
  const Stamp now = stamp_at(driven.seconds + 0.1);
  const auto guesses = driven.predictor.guesses(now, odometry);
  EXPECT_TRUE(pose_near(guesses.front().local_T_robot, driven.local_T_robot * kStep, 1e-9, 1e-9));
  EXPECT_FALSE(guesses.front().measured);
  // Nor is it held against odometry: afterwards it is believed as before.
  driven.predictor.settle(now, driven.local_T_robot * kStep, odometry, {true, true});
  OdometryReading next{driven.local_T_robot * kStep};
  next.silent_until = odometry.silent_until;
  const auto after = driven.predictor.guesses(stamp_at(driven.seconds + 0.2), next);
  EXPECT_TRUE(after.front().measured);
  EXPECT_EQ(driven.predictor.check().translation().jumps(), 0);
}

TEST(MotionPredictor, OfAMotionDuringWhichOdometryWasSilentTheRestIsKnown) {
  Driven driven = drive(true);
  const Stamp seen = stamp_at(driven.seconds);
  driven.predictor.forget_unseen();
  const OdometryReading at_last{driven.local_T_robot};
  OdometryReading odometry = at_last;
  Pose2 placed = driven.local_T_robot;
  double seconds = driven.seconds;
  // Covered for two seconds, of which nothing is told between the fifth and the sixth scan.
  for (int i = 0; i < 20; ++i) {
    const bool silent = i == 5;
    seconds += silent ? 1.5 : 0.1;
    odometry.odom_T_robot = odometry.odom_T_robot * kStep;
    if (silent) odometry.silent_until = stamp_at(seconds - 0.01);
    if (i == 19) break;
    placed = driven.predictor.guesses(stamp_at(seconds), odometry).front().local_T_robot;
    driven.predictor.settle(stamp_at(seconds), placed, odometry, {});
  }
  EXPECT_FALSE(driven.predictor.told(at_last, seen, odometry)) << "not all of it";
  const auto told = driven.predictor.partly_told(at_last, seen, odometry, stamp_at(seconds));
  ASSERT_TRUE(told);
  EXPECT_NEAR(told->untold_s, 1.5, 1e-9);
  const auto steps = [](int count) {
    Pose2 motion;
    for (int i = 0; i < count; ++i) motion = motion * kStep;
    return motion;
  };
  EXPECT_TRUE(pose_near(told->before, steps(5), 1e-9, 1e-9));
  EXPECT_TRUE(pose_near(told->after, steps(14), 1e-9, 1e-9));
  EXPECT_GT(told->sigma_m, 0.0);
  // From a scan that the laser placed meanwhile nothing is known.
  EXPECT_FALSE(
      driven.predictor.partly_told(odometry, stamp_at(seconds - 0.1), odometry, stamp_at(seconds)));
  driven.predictor.settle(stamp_at(seconds), placed, odometry, {true, true});
  EXPECT_FALSE(driven.predictor.partly_told(at_last, seen, odometry, stamp_at(seconds + 0.1)));
}

TEST(MotionPredictor, AcrossAGapTheRobotMostLikelyWentOn) {
  const Driven driven = drive(false);
  const Stamp later = stamp_at(driven.seconds + 2.0);
  const OdometryReading silent{.silent_until = later};
  const auto guesses = driven.predictor.guesses(later, silent);
  ASSERT_EQ(guesses.size(), 1U);
  const Pose2 gone = driven.local_T_robot.inverse() * guesses.front().local_T_robot;
  EXPECT_NEAR(std::hypot(gone.x, gone.y), 1.0, 0.05) << "half a metre a second";
  EXPECT_NEAR(gone.yaw, 0.2, 1e-6) << "turning for a second";
  EXPECT_NEAR(1.0 / std::sqrt(guesses.front().information(0, 0)), 2.0, 1e-6);
}

TEST(MotionPredictor, WithoutOdometryNothingIsGuessedAcrossAGap) {
  const Driven driven = drive(false);
  const auto guesses = driven.predictor.guesses(stamp_at(driven.seconds + 2.0), {});
  ASSERT_EQ(guesses.size(), 1U);
  const Pose2 gone = driven.local_T_robot.inverse() * guesses.front().local_T_robot;
  EXPECT_NEAR(std::hypot(gone.x, gone.y), 0.0, 1e-9);
}

}  // namespace
}  // namespace loopstone
