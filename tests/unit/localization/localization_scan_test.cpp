#include "loopstone/localization/localization_scan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "drawn_room.hpp"

namespace loopstone {
namespace {

using test::drawn;
using test::furnished_room;
using test::rectangle;
using test::scan_from;
using test::Scanner;
using test::together;
using test::Walls;

const Eigen::Vector2d kLow{0.0, 0.0};
const Eigen::Vector2d kHigh{8.0, 6.0};
const Pose2 kMount{0.2, 0.05, 0.1};

LocalizationScan view_of(const LaserScan& scan, int count = 180) {
  return view_for_localization(scan, kMount, Tangent2::Zero(), count);
}

LocalizationScan view_from(const Walls& walls, const Pose2& pose, const Scanner& scanner = {}) {
  return view_of(scan_from(walls, pose, kMount, scanner));
}

TEST(LocalizationScan, KeepsAllReturnsAndAsManyBeamsAsAskedFor) {
  const LaserScan scan = scan_from(furnished_room(), {3.0, 2.0, 0.4}, kMount, {});
  const LocalizationScan few = view_of(scan, 50);
  EXPECT_EQ(few.points_robot.size(), scan.ranges_m.size());
  EXPECT_EQ(few.weighed.size(), 50U);
  EXPECT_EQ(few.lasers.front().ranges_m.size(), 50U);
  const LocalizationScan all = view_of(scan, 2000);
  EXPECT_EQ(all.weighed.size(), scan.ranges_m.size());
  EXPECT_EQ(all.lasers.front().ranges_m.size(), scan.ranges_m.size());
}

TEST(LocalizationScan, ItsPointsLieOnTheWallsFromTheRobotsPose) {
  const Walls room = furnished_room();
  const Pose2 pose{3.0, 2.0, 0.4};
  const LocalizationScan view = view_from(room, pose);
  ASSERT_FALSE(view.points_robot.empty());
  for (const auto& point : view.points_robot)
    EXPECT_LT(distance_to_walls(room, pose * point), 1e-5);
  const SeenByLaser& laser = view.lasers.front();
  ASSERT_EQ(laser.angles_rad.size(), laser.ranges_m.size());
  for (std::size_t i = 0; i < laser.ranges_m.size(); ++i) {
    const auto range = static_cast<double>(laser.ranges_m[i]);
    const double angle = laser.angles_rad[i];
    const Eigen::Vector2d seen{range * std::cos(angle), range * std::sin(angle)};
    EXPECT_LT(distance_to_walls(room, pose * (kMount * seen)), 1e-5);
  }
}

TEST(LocalizationScan, BadBeamsAreLeftOutAndBeamsWithoutReturnsStay) {
  LaserScan scan = scan_from(furnished_room(), {3.0, 2.0, 0.4}, kMount, {});
  for (std::size_t i = 0; i < 100; ++i) scan.ranges_m[i] = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 100; i < 150; ++i) scan.ranges_m[i] = std::numeric_limits<float>::infinity();
  const LocalizationScan view = view_of(scan, 2000);
  EXPECT_EQ(view.points_robot.size(), scan.ranges_m.size() - 150);
  EXPECT_EQ(view.weighed.size(), scan.ranges_m.size() - 150);
  EXPECT_EQ(view.lasers.front().ranges_m.size(), scan.ranges_m.size() - 100);
}

TEST(LocalizationScan, OfNothingIsEmpty) {
  LaserScan scan = scan_from(furnished_room(), {3.0, 2.0, 0.4}, kMount, {});
  scan.ranges_m.clear();
  const LocalizationScan view = view_of(scan);
  EXPECT_TRUE(view.points_robot.empty());
  EXPECT_TRUE(view.lasers.front().ranges_m.empty());
  const LocalizationMap map(drawn(furnished_room(), kLow, kHigh));
  const BeamFit fit = fit_beams(view, map, {3.0, 2.0, 0.4});
  EXPECT_EQ(fit.explained, 0.0);
  EXPECT_EQ(fit.violations, 0.0);
  EXPECT_EQ(fit.unexpected, 0.0);
}

TEST(BeamFitLaws, AtTheTruthAllIsExplained) {
  const Walls room = furnished_room();
  const LocalizationMap map(drawn(room, kLow, kHigh));
  for (const Pose2& pose : {Pose2{3.0, 2.0, 0.4}, Pose2{1.5, 3.0, -2.0}, Pose2{6.5, 3.5, 3.0}}) {
    const BeamFit fit = fit_beams(view_from(room, pose), map, pose);
    EXPECT_GT(fit.explained, 0.99);
    EXPECT_LT(fit.violations, 0.01);
    EXPECT_LT(fit.unexpected, 0.01);
  }
}

TEST(BeamFitLaws, BeamsThatGoThroughAWallOfTheMapViolateIt) {
  // The map's room ends at 5 m, the world's at 8 m.
  const Pose2 pose{3.0, 3.0, 0.0};
  const LocalizationMap map(drawn(rectangle({0.0, 0.0}, {5.0, 6.0}), kLow, kHigh));
  const BeamFit fit = fit_beams(view_from(rectangle(kLow, kHigh), pose), map, pose);
  // From 1.8 m its far side is seen under 2 atan(3 / 1.8), about 118 of 270 deg, of which a few
  // beams end near its corners.
  EXPECT_GT(fit.violations, 0.35);
  EXPECT_LT(fit.violations, 0.45);
  EXPECT_LT(fit.unexpected, 0.01);
  EXPECT_LT(fit.explained, 0.65);
}

TEST(BeamFitLaws, ABeamThatEndsOnAWallViolatesNone) {
  // A wall that is gone, but what lies beyond it is on the map: that explains the beam.
  const Walls room = furnished_room();
  const Pose2 pose{3.0, 3.0, 0.0};
  const Walls wall = {{{5.0, 2.0}, {5.0, 4.0}}};
  const LocalizationMap map(drawn(together({room, wall}), kLow, kHigh));
  const BeamFit fit = fit_beams(view_from(room, pose), map, pose);
  EXPECT_GT(fit.explained, 0.95);
  EXPECT_LT(fit.violations, 0.01);
}

TEST(BeamFitLaws, AThingThatTheMapLacksIsUnexpected) {
  const Walls room = furnished_room();
  const Pose2 pose{3.0, 3.0, 0.0};
  const Walls thing = {{{5.0, 2.0}, {5.0, 4.0}}};
  const LocalizationMap map(drawn(room, kLow, kHigh));
  const BeamFit fit = fit_beams(view_from(together({room, thing}), pose), map, pose);
  EXPECT_GT(fit.unexpected, 0.15);
  EXPECT_LT(fit.unexpected, 0.25);
  EXPECT_LT(fit.violations, 0.01);
  EXPECT_LT(fit.explained, 0.85);
  EXPECT_GT(fit.explained, 0.75);
}

TEST(BeamFitLaws, ABeamWithoutReturnSpeaksAgainstANearWallOnly) {
  const Walls room = furnished_room();
  const LocalizationMap map(drawn(room, kLow, kHigh));
  const Pose2 pose{3.0, 3.0, 0.0};
  LaserScan scan = scan_from(room, pose, kMount, {});
  std::fill(scan.ranges_m.begin(), scan.ranges_m.end(), std::numeric_limits<float>::infinity());
  scan.range_max_m = 30.0;
  EXPECT_GT(fit_beams(view_of(scan), map, pose).silent, 0.99);
  EXPECT_EQ(fit_beams(view_of(scan), map, pose).violations, 0.0);
  scan.range_max_m = 2.0;  // dark walls at that distance may send nothing back
  EXPECT_LT(fit_beams(view_of(scan), map, pose).silent, 0.2);
}

TEST(BeamFitLaws, WhereTheMapKnowsNothingNothingSpeaksForOrAgainstAPose) {
  const Walls room = furnished_room();
  const Pose2 pose{3.0, 3.0, 0.0};
  Grid<std::int8_t> occupancy = drawn(room, kLow, kHigh);
  const BeamFit whole = fit_beams(view_from(room, pose), LocalizationMap(occupancy), pose);
  EXPECT_GT(whole.known, 0.99);
  // The half of the map that the robot has not seen yet.
  for (int row = 0; row < occupancy.frame().rows; ++row) {
    for (int column = 0; column < occupancy.frame().columns; ++column) {
      const Cell cell{column, row};
      if (occupancy.frame().centre_of(cell).x() > 4.0) occupancy[cell] = -1;
    }
  }
  const BeamFit half = fit_beams(view_from(room, pose), LocalizationMap(occupancy), pose);
  EXPECT_LT(half.known, 0.8);
  EXPECT_GT(half.known, 0.3);
  EXPECT_GT(half.explained, 0.95);
  EXPECT_LT(half.violations + half.unexpected, 0.02);
}

TEST(BeamFitLaws, ABeamBesideAnEdgeMayPassIt) {
  // The pose is off by less than a beam: the door's edge is passed on the wrong side.
  const Walls room = rectangle(kLow, kHigh);
  const Walls wall = {{{5.0, 0.0}, {5.0, 2.6}}, {{5.0, 3.4}, {5.0, 6.0}}};
  const Pose2 pose{3.0, 3.0, 0.0};
  const LocalizationMap map(drawn(together({room, wall}), kLow, kHigh));
  const BeamFit fit =
      fit_beams(view_from(together({room, wall}), pose), map, pose * Pose2{0.0, 0.0, 0.02});
  EXPECT_LT(fit.violations, 0.005);
  EXPECT_LT(fit.unexpected, 0.005);
}

TEST(BeamFitLaws, AWrongPoseExplainsLess) {
  const Walls room = furnished_room();
  const LocalizationMap map(drawn(room, kLow, kHigh));
  const Pose2 truth{3.0, 3.0, 0.3};
  const LocalizationScan view = view_from(room, truth);
  double before = fit_beams(view, map, truth).explained;
  for (const double off_m : {0.2, 0.5, 1.0}) {
    const double explained =
        fit_beams(view, map, truth * Pose2{off_m, 0.5 * off_m, 0.3 * off_m}).explained;
    EXPECT_LT(explained, before) << off_m;
    before = explained;
  }
  EXPECT_LT(before, 0.5);
}

TEST(BeamFitLaws, OutsideTheMapNothingIsExplained) {
  const Walls room = furnished_room();
  const LocalizationMap map(drawn(room, kLow, kHigh));
  const LocalizationScan view = view_from(room, {3.0, 3.0, 0.3});
  EXPECT_EQ(fit_beams(view, map, {1000.0, -500.0, 0.0}).explained, 0.0);
}

}  // namespace
}  // namespace loopstone
