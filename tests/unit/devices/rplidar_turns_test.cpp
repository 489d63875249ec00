#include "devices/rplidar_turns.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();

RplidarNode node(double angle_deg, double range_m, int quality = 10) {
  return {.angle_rad = angle_deg * kPi / 180.0, .range_m = range_m, .quality = quality};
}

/// Turns of ten measurements; the fourth one of turn `damaged` comes after a gap.
std::vector<RplidarTurn> turns_of(int first, int count, int damaged, RplidarTurns& turns) {
  std::vector<RplidarTurn> all;
  for (int i = first; i < count; ++i) {
    RplidarNode one = node(36.0 * (i % 10), 1.0);
    one.begins_turn = i % 10 == 0;
    one.after_gap = i == 10 * damaged + 3;
    one.sample = i;
    if (auto turn = turns.add(one)) all.push_back(*turn);
  }
  return all;
}

TEST(RplidarTurns, TheFirstBeginsWithItsFlag) {
  RplidarTurns turns;
  const auto all = turns_of(4, 45, -1, turns);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].first_sample, 10);
  EXPECT_EQ(all[0].end_sample, 20);
  EXPECT_EQ(all[0].nodes.size(), 10U);
  EXPECT_EQ(turns.broken(), 0);
}

TEST(RplidarTurns, WhatHasAGapIsLeftOutAndCounted) {
  RplidarTurns turns;
  const auto all = turns_of(0, 51, 2, turns);
  ASSERT_EQ(all.size(), 4U);
  EXPECT_EQ(all[1].first_sample, 10);
  EXPECT_EQ(all[2].first_sample, 30);
  EXPECT_FALSE(all[1].after_gap);
  EXPECT_TRUE(all[2].after_gap);
  EXPECT_FALSE(all[3].after_gap);
  EXPECT_EQ(turns.broken(), 1);
}

TEST(RplidarGrid, TurnsClockwise) {
  const RplidarGrid grid{4, 0.1, 10.0};
  EXPECT_DOUBLE_EQ(grid.angle_increment_rad(), -kPi / 2.0);
  const LaserScan scan = grid.scan_of(
      {.nodes = {node(0.0, 1.0), node(90.0, 2.0), node(180.0, 3.0), node(270.0, 4.0)}}, false);
  // What is a quarter turn clockwise from the front is on the right.
  EXPECT_EQ(scan.ranges_m, (std::vector<float>{1.0F, 2.0F, 3.0F, 4.0F}));
  EXPECT_DOUBLE_EQ(scan.angle_rad(1), -kPi / 2.0);
  EXPECT_TRUE(scan.intensities.empty());
}

TEST(RplidarGrid, TheNearestReturnOfABeamCounts) {
  const RplidarGrid grid{4, 0.1, 10.0};
  const LaserScan scan =
      grid.scan_of({.nodes = {node(80.0, 5.0, 7), node(90.0, 2.0, 8), node(95.0, 0.0, 0),
                              node(359.0, 6.0, 9), node(1.0, 0.0, 0), node(180.0, 0.0, 0)}},
                   true);
  EXPECT_EQ(scan.ranges_m[0], 6.0F);
  EXPECT_EQ(scan.ranges_m[1], 2.0F);
  EXPECT_EQ(scan.ranges_m[2], kNothing);
  EXPECT_TRUE(std::isnan(scan.ranges_m[3]));  // nobody looked there
  EXPECT_EQ(scan.intensities, (std::vector<float>{9.0F, 8.0F, 0.0F, 0.0F}));
}

TEST(RplidarGrid, RangesBeyondItsReachAreNoReturnsAndThoseTooNearAreBad) {
  const RplidarGrid grid{4, 0.15, 12.0};
  const LaserScan scan =
      grid.scan_of({.nodes = {node(0.0, 12.1), node(90.0, 0.1), node(180.0, 12.0)}}, false);
  EXPECT_EQ(scan.ranges_m[0], kNothing);
  EXPECT_TRUE(std::isnan(scan.ranges_m[1]));
  EXPECT_EQ(scan.ranges_m[2], 12.0F);
}

TEST(RplidarGrid, EvenTurnsLeaveNoBeamEmpty) {
  // Of any phase, and a motor that is 4 % faster than the one that was learned from.
  const RplidarGrid grid{rplidar_beams(400), 0.1, 10.0};
  EXPECT_EQ(grid.beams, 380);
  for (double phase = 0.0; phase < 1.0; phase += 0.1) {
    RplidarTurn turn;
    for (int i = 0; i < 384; ++i) turn.nodes.push_back(node((i + phase) * 360.0 / 384.0, 3.0));
    const LaserScan scan = grid.scan_of(turn, false);
    for (const float range_m : scan.ranges_m) EXPECT_EQ(range_m, 3.0F);
  }
}

}  // namespace
}  // namespace loopstone
