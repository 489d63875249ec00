#include "localization/pose_track.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drawn_room.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::drawn;
using test::drawn_solid;
using test::furnished_room;
using test::pose_near;
using test::rectangle;
using test::scan_from;
using test::Walls;

const Eigen::Vector2d kLow{0.0, 0.0};
const Eigen::Vector2d kHigh{8.0, 6.0};
const Pose2 kMount{0.2, 0.05, 0.1};

/// Returns in the robot's frame.
std::vector<Eigen::Vector2d> points_from(const Walls& walls, const Pose2& pose) {
  const LaserScan scan = scan_from(walls, pose, kMount, {});
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < scan.ranges_m.size(); i += 3) {
    const auto range = static_cast<double>(scan.ranges_m[i]);
    const double angle = scan.angle_rad(i);
    if (std::isfinite(range))
      points.push_back(kMount * Eigen::Vector2d(range * std::cos(angle), range * std::sin(angle)));
  }
  return points;
}

/// Of a robot that has seen a room from many poses.
double learned_offset_m(const Walls& walls, const Grid<std::int8_t>& map) {
  const MapField field(map);
  RangeOffset offset;
  for (int i = 0; i < 150; ++i) {
    const Pose2 pose{3.0 + 1.2 * std::cos(0.7 * i), 2.4 + 0.8 * std::sin(1.1 * i), 0.37 * i};
    offset.learn(points_from(walls, pose), kMount.translation(), field, pose);
  }
  return offset.metres();
}

TEST(RangeOffset, IsHalfACellOnAMapDrawnFromNearEdges) {
  const double offset_m = learned_offset_m(rectangle(kLow, kHigh), drawn_solid(kLow, kHigh));
  EXPECT_NEAR(offset_m, 0.025, 0.008);
}

TEST(RangeOffset, IsHalfOfALargerCellToo) {
  const double offset_m = learned_offset_m(rectangle(kLow, kHigh), drawn_solid(kLow, kHigh, 0.1));
  EXPECT_NEAR(offset_m, 0.05, 0.015);
}

TEST(RangeOffset, IsNothingWhereWallsLieInTheMiddleOfCells) {
  // Walls on the centres of cells.
  const Walls walls = rectangle({0.025, 0.025}, {8.025, 6.025});
  EXPECT_NEAR(learned_offset_m(walls, drawn(walls, kLow, kHigh)), 0.0, 0.008);
}

TEST(RangeOffset, MovesPointsAwayFromTheLaser) {
  const Eigen::Vector2d laser{0.2, 0.0};
  const std::vector<Eigen::Vector2d> points = {{1.2, 0.0}, {0.2, -2.0}};
  const auto moved = RangeOffset{}.applied(points, laser, 0.1);
  ASSERT_EQ(moved.size(), 2U);
  EXPECT_LT((moved[0] - Eigen::Vector2d(1.3, 0.0)).norm(), 1e-12);
  EXPECT_LT((moved[1] - Eigen::Vector2d(0.2, -2.1)).norm(), 1e-12);
  EXPECT_EQ(RangeOffset{}.applied(points, laser), points);
}

PoseWithCovariance2 sure(const Pose2& pose, double sigma_m = 0.02, double sigma_rad = 0.005) {
  PoseWithCovariance2 estimate{.pose = pose};
  estimate.covariance.diagonal() << sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad;
  return estimate;
}

PoseWithCovariance2 step(double ahead_m) { return sure({ahead_m, 0.0, 0.0}, 0.001, 0.0001); }

TEST(PoseTrack, IsDrawnToTheWalls) {
  const Walls room = furnished_room();
  const MapField field(drawn(room, kLow, kHigh));
  const Pose2 truth{3.0, 3.0, 0.3};
  PoseTrack track(sure(truth * Pose2{0.06, -0.05, 0.02}, 0.1, 0.05));
  RangeOffset offset;
  const Eigen::Matrix3d before = track.map_T_robot().covariance;
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(track.refine(points_from(room, truth), kMount.translation(), field, offset));
    track.advance(OdometryStep{step(0.0)});
  }
  EXPECT_TRUE(pose_near(track.map_T_robot().pose, truth, 0.025, 0.006));
  EXPECT_LT(track.map_T_robot().covariance.trace(), 0.1 * before.trace());
}

TEST(PoseTrack, PeopleBeforeTheWallsDoNotDrawIt) {
  const Walls room = furnished_room();
  const MapField field(drawn(room, kLow, kHigh));
  const Pose2 truth{3.0, 3.0, 0.0};
  // Two of them walk ahead of the robot, half a metre before a wall and more.
  const Walls people = {{{5.0, 1.8}, {5.2, 2.8}}, {{5.2, 3.3}, {5.0, 4.3}}};
  const auto points = points_from(test::together({room, people}), truth);
  PoseTrack track(sure(truth * Pose2{0.02, -0.02, 0.005}));
  RangeOffset offset;
  for (int i = 0; i < 20; ++i) {
    track.advance(OdometryStep{step(0.0)});
    ASSERT_TRUE(track.refine(points, kMount.translation(), field, offset));
  }
  EXPECT_TRUE(pose_near(track.map_T_robot().pose, truth, 0.025, 0.006));
  EXPECT_LT(track.innovation(), 0.5);
}

TEST(PoseTrack, InnovationIsSmallWhenAllIsWellAndGrowsWhenNothingFits) {
  const Walls room = furnished_room();
  const MapField field(drawn(room, kLow, kHigh));
  const Pose2 truth{3.0, 3.0, 0.3};
  PoseTrack track(sure(truth));
  RangeOffset offset;
  const auto points = points_from(room, truth);
  for (int i = 0; i < 30; ++i) {
    track.advance(OdometryStep{step(0.0)});
    ASSERT_TRUE(track.refine(points, kMount.translation(), field, offset));
  }
  EXPECT_LT(track.innovation(), 0.5);
  // A scan from elsewhere.
  const auto others = points_from(room, {1.0, 1.2, -2.0});
  const Pose2 before = track.map_T_robot().pose;
  for (int i = 0; i < 10; ++i)
    EXPECT_FALSE(track.refine(others, kMount.translation(), field, offset));
  EXPECT_GT(track.innovation(), 5.0);
  EXPECT_EQ(track.map_T_robot().pose, before) << "what is not believed moves nothing";
}

/// Walls on the centres of cells, the ends out of sight.
const Walls kCorridor = {{{-50.0, 0.025}, {150.0, 0.025}}, {{-50.0, 2.025}, {150.0, 2.025}}};

MapField corridor_map() { return MapField(drawn(kCorridor, {-20.0, 0.0}, {80.0, 2.0})); }

TEST(PoseTrack, AlongACorridorItsDoubtGrowsWithTheWay) {
  const MapField field = corridor_map();
  PoseTrack track(sure({0.0, 1.0, 0.0}));
  RangeOffset offset;
  const auto points = points_from(kCorridor, {0.0, 1.0, 0.0});
  std::vector<double> along;
  std::vector<double> across;
  for (int i = 1; i <= 400; ++i) {
    track.advance(OdometryStep{step(0.1)});
    ASSERT_TRUE(track.refine(points, kMount.translation(), field, offset));
    if (i % 100 != 0) continue;
    along.push_back(std::sqrt(track.map_T_robot().covariance(0, 0)));
    across.push_back(std::sqrt(track.map_T_robot().covariance(1, 1)));
  }
  // An error of scale of 1.5 % grows with the way, not with its root.
  EXPECT_GT(along[3], 0.015 * 40.0);
  EXPECT_LT(along[3], 0.03 * 40.0);
  EXPECT_GT(along[3] / along[0], 3.0);
  for (const double sigma : across) EXPECT_LT(sigma, 0.02);
  EXPECT_NEAR(track.map_T_robot().pose.y, 1.0, 0.01);
}

TEST(PoseTrack, AlongACorridorTheDoubtOfAGuessGrowsWithTheTime) {
  constexpr double kStepSigmaM = 0.04;
  const MapField field = corridor_map();
  PoseTrack track(sure({0.0, 1.0, 0.0}));
  RangeOffset offset;
  const auto points = points_from(kCorridor, {0.0, 1.0, 0.0});
  std::vector<double> along;
  for (int i = 1; i <= 100; ++i) {
    track.advance(sure({0.05, 0.0, 0.0}, kStepSigmaM, 0.001));
    ASSERT_TRUE(track.refine(points, kMount.translation(), field, offset));
    EXPECT_LT(track.map_T_robot().covariance(1, 1), 0.02 * 0.02);
    if (i % 25 == 0) along.push_back(std::sqrt(track.map_T_robot().covariance(0, 0)));
  }
  // A velocity that is wrong stays so: after n steps it is n times a step's sigma, not by their
  // root. That the map ends somewhere bounds it.
  EXPECT_GT(along[0], 0.8 * 25 * kStepSigmaM);
  EXPECT_LT(along[0], 1.3 * 25 * kStepSigmaM);
  EXPECT_GT(along[1] / along[0], 1.6);
  EXPECT_GT(along[3], 4.0 * std::sqrt(100.0) * kStepSigmaM);
}

TEST(PoseTrack, WhatLastsIsTwiceTheProductOfBothAlongEachAxis) {
  // (s + d)^2 = s^2 + 2 s d + d^2, of a position that is sure one way and not the other.
  const Eigen::Rotation2Dd turn(0.4);
  const Eigen::Matrix2d position =
      turn * Eigen::Vector2d(0.09, 0.0004).asDiagonal() * turn.inverse().toRotationMatrix();
  const Eigen::Matrix2d lasting =
      turn.inverse() * lasting_covariance(position, 0.05) * turn.toRotationMatrix();
  EXPECT_NEAR(lasting(0, 0), 2.0 * 0.3 * 0.05, 1e-12);
  EXPECT_NEAR(lasting(1, 1), 2.0 * 0.02 * 0.05, 1e-12);
  EXPECT_NEAR(lasting(0, 1), 0.0, 1e-12);
}

/// What drives round and round in a room by an odometer that is wrong all the time.
TEST(PoseTrack, LearnsWhatOdometryIsWrongByAllTheTime) {
  const Walls room = furnished_room();
  const MapField field(drawn(room, kLow, kHigh));
  Pose2 truth{3.0, 2.4, 0.0};
  PoseTrack track(sure(truth));
  const OdometryErrors before = track.errors();
  RangeOffset offset;
  for (int i = 0; i < 800; ++i) {
    const Pose2 real{0.05, 0.0, 0.05};
    truth = truth * real;
    // Wheels said to be 3 % smaller than they are, a gyro with a scale of 0.98.
    track.advance(OdometryStep{sure({real.x / 1.03, 0.0, 0.98 * real.yaw}, 0.003, 0.001)});
    ASSERT_TRUE(track.refine(points_from(room, truth), kMount.translation(), field, offset));
  }
  const OdometryErrors learned = track.errors();
  EXPECT_NEAR(learned.mean.x(), 0.03, 0.01);
  const Pose2 corrected = learned.corrected({0.05 / 1.03, 0.0, 0.98 * 0.05});
  EXPECT_NEAR(corrected.x, 0.05, 0.0005);
  EXPECT_NEAR(corrected.yaw, 0.05, 0.0003);
  EXPECT_LT(learned.covariance(0, 0), 0.25 * before.covariance(0, 0));
}

/// Scans that come a tenth of a second late, from a robot that turns on the spot now and then: its
/// odometry turns when scans do not yet.
TEST(PoseTrack, LearnsHowLateScansAre) {
  constexpr double kPeriodS = 0.1;
  const Walls room = furnished_room();
  const MapField field(drawn(room, kLow, kHigh));
  const auto rate_at = [](int scan) { return scan % 20 < 10 ? 0.0 : 1.0; };
  Pose2 truth{3.0, 2.4, 0.0};
  PoseTrack track(sure(truth));
  RangeOffset offset;
  for (int i = 0; i < 200; ++i) {
    truth = truth * Pose2{0.0, 0.0, kPeriodS * rate_at(i)};
    const Tangent2 change(0.0, 0.0, rate_at(i + 1) - rate_at(i));
    track.advance(OdometryStep{sure({0.0, 0.0, kPeriodS * rate_at(i + 1)}, 0.003, 0.001), change});
    ASSERT_TRUE(track.refine(points_from(room, truth), kMount.translation(), field, offset)) << i;
    EXPECT_TRUE(pose_near(track.map_T_robot().pose, truth, 0.03, 0.02)) << i;
  }
  EXPECT_NEAR(track.errors().mean[3], -kPeriodS, 0.02);
}

TEST(PoseTrack, WhatNoOdometryToldTeachesNothing) {
  PoseTrack track(sure({1.0, 2.0, 0.3}));
  for (int i = 0; i < 10; ++i) track.advance(step(0.1));
  EXPECT_EQ(track.errors().mean, Eigen::Vector4d::Zero());
  EXPECT_EQ(track.errors().covariance, OdometryErrors{}.covariance);
}

TEST(PoseTrack, NoNumberOfScansMakesItSurerThanTheWalls) {
  const Walls room = furnished_room();
  const MapField field(drawn(room, kLow, kHigh));
  const Pose2 truth{3.0, 3.0, 0.3};
  PoseTrack track(sure(truth));
  RangeOffset offset;
  const auto points = points_from(room, truth);
  for (int i = 0; i < 300; ++i) {
    track.advance(OdometryStep{step(0.0)});
    ASSERT_TRUE(track.refine(points, kMount.translation(), field, offset));
  }
  // A cell of 5 cm is known to its width by the root of 12, and several walls share in that.
  const double sigma_m = std::sqrt(track.covariance()(0, 0));
  EXPECT_GT(sigma_m, 0.005);
  EXPECT_LT(sigma_m, 0.03);
  EXPECT_GT(track.covariance()(0, 0), track.map_T_robot().covariance(0, 0));
}

TEST(PoseTrack, ItsCovarianceStaysSymmetricAndPositive) {
  const Walls room = furnished_room();
  const MapField field(drawn(room, kLow, kHigh));
  Pose2 truth{2.0, 3.0, 0.0};
  PoseTrack track(sure(truth, 0.3, 0.2));
  RangeOffset offset;
  for (int i = 0; i < 60; ++i) {
    const PoseWithCovariance2 motion = sure({0.03, 0.0, 0.02}, 0.005, 0.002);
    truth = truth * motion.pose;
    track.advance(OdometryStep{motion});
    track.refine(points_from(room, truth), kMount.translation(), field, offset);
    const Eigen::Matrix3d& covariance = track.map_T_robot().covariance;
    ASSERT_LT((covariance - covariance.transpose()).norm(), 1e-12);
    ASSERT_GT(covariance.determinant(), 0.0);
    ASSERT_TRUE(pose_near(track.map_T_robot().pose, truth, 0.05, 0.02)) << "step " << i;
  }
}

}  // namespace
}  // namespace loopstone
