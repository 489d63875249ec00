#include "loopstone/slam/robot_correction.hpp"

#include <gtest/gtest.h>

namespace loopstone {
namespace {

Calibration mirrored() {
  Calibration found;
  found.laser_is_mirrored = true;
  found.mirror_is_in_doubt = true;
  return found;
}

Calibration with_sweep(double sweep_s) {
  Calibration found;
  found.sweep_s.value = sweep_s;
  found.sweep_is_off = true;
  return found;
}

Calibration with_scale(double scale) {
  Calibration found;
  found.odometry_scale = scale;
  found.scale_is_off = true;
  return found;
}

TEST(RobotCorrection, WhatOneMappingFindsStandsBesideWhatTheOneBeforeFound) {
  const Calibration both = beside(with_sweep(0.075), mirrored());
  EXPECT_TRUE(both.laser_is_mirrored);
  EXPECT_TRUE(both.mirror_is_in_doubt);
  EXPECT_TRUE(both.sweep_is_off);
  EXPECT_EQ(both.sweep_s.value, 0.075);
  const RobotModel robot = corrected_robot({}, beside(both, with_scale(0.98)));
  ASSERT_EQ(robot.lidars.size(), 1U);
  EXPECT_TRUE(robot.lidars[0].upside_down);
  EXPECT_EQ(robot.lidars[0].sweep_s, 0.075);
  EXPECT_EQ(robot.odometry_scale, 0.98);
}

TEST(RobotCorrection, TheNewestSweepIsTaken) {
  EXPECT_EQ(beside(with_sweep(0.07), with_sweep(0.08)).sweep_s.value, 0.08);
}

TEST(RobotCorrection, ALaserThatWasTurnedOverTwiceIsAsItWasGiven) {
  const Calibration twice = beside(mirrored(), mirrored());
  EXPECT_FALSE(twice.laser_is_mirrored);
  EXPECT_FALSE(twice.map_is_bent());
}

TEST(RobotCorrection, WhatAMirroredLaserTellsOfTheWayIsForgotten) {
  Calibration found = mirrored();
  found.odometry_scale = 0.9;
  found.scale_is_off = true;
  EXPECT_FALSE(beside({}, found).scale_is_off);
  EXPECT_FALSE(beside(with_scale(0.9), mirrored()).scale_is_off);
  EXPECT_TRUE(beside(mirrored(), with_scale(0.97)).scale_is_off) << "put right, it is believed";
}

}  // namespace
}  // namespace loopstone
