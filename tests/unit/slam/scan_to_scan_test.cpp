#include "loopstone/slam/scan_to_scan.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "loopstone/evaluation/trajectory_error.hpp"
#include "slam/scan_edges.hpp"
#include "support/pose_near.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using test::pose_near;

/// A robot that drives about the furnished room and believes that it turns and drives 5 % more than
/// it does.
struct RoomDrive {
  std::vector<SensorMessage> messages;
  Trajectory truth;
  RobotModel robot;
};

RoomDrive drive_about_the_room(bool with_odometry, std::size_t steps_max = 1000) {
  RoomDrive drive;
  Rng rng(5);
  test::Scanner scanner;
  scanner.noise_m = 0.01;
  const auto poses =
      test::drive_through({{2.0, 1.5}, {6.0, 1.5}, {6.0, 4.5}, {3.0, 4.5}}, 0.1, 0.1);
  const auto walls = test::furnished_room();
  const Pose2 robot_T_lidar{0.1, 0.0, 0.0};
  drive.robot.lidars.front().robot_T_lidar = robot_T_lidar;
  Pose2 odom_T_robot;
  for (std::size_t i = 0; i < poses.size() && i < steps_max; ++i) {
    const Stamp stamp = Stamp::from_seconds(100.0 + 0.2 * static_cast<double>(i));
    if (i > 0)
      odom_T_robot = odom_T_robot * exp(Tangent2(1.05 * log(poses[i - 1].inverse() * poses[i])));
    if (with_odometry) drive.messages.emplace_back(OdometryPose{stamp, odom_T_robot});
    LaserScan scan = test::scan_from(walls, poses[i], robot_T_lidar, scanner, &rng);
    scan.stamp = stamp;
    drive.messages.emplace_back(std::move(scan));
    drive.truth.append(stamp, poses[i]);
  }
  return drive;
}

MapResult map_of(const RoomDrive& drive, const ScanToScanOptions& options = {},
                 Threads threads = {1}, const ProgressCallback& progress = {}) {
  ScanToScanMapper mapper(drive.robot, options, threads);
  for (const SensorMessage& message : drive.messages) mapper.add(message);
  return mapper.finish(progress);
}

double error_m(const Trajectory& estimate, const Trajectory& truth) {
  return absolute_error(estimate, truth, Alignment::kSe2).translation_m.rmse;
}

TEST(ScanToScan, CorrectsOdometry) {
  const RoomDrive drive = drive_about_the_room(true);
  const MapResult result = map_of(drive);
  EXPECT_EQ(result.trajectory.size(), drive.truth.size());
  EXPECT_GT(error_m(result.odometry, drive.truth), 0.1);
  EXPECT_LT(error_m(result.trajectory, drive.truth), 0.03);
  EXPECT_TRUE(result.complete);
  EXPECT_TRUE(result.warnings.empty());
  EXPECT_FALSE(result.map.log_odds.empty());
}

TEST(ScanToScan, DoesWithoutOdometry) {
  const RoomDrive drive = drive_about_the_room(false);
  const MapResult result = map_of(drive);
  EXPECT_TRUE(result.odometry.empty());
  EXPECT_EQ(result.trajectory.size(), drive.truth.size());
  EXPECT_LT(error_m(result.trajectory, drive.truth), 0.05);
}

TEST(ScanToScan, LinksWhatTheOptionsSay) {
  const RoomDrive drive = drive_about_the_room(true, 31);
  ScanToScanOptions options;
  options.interval = 0;
  EXPECT_EQ(map_of(drive, options).graph.edges.size(), 30U);
  options.interval = 10;
  const MapResult ends = map_of(drive, options);
  ASSERT_EQ(ends.graph.edges.size(), 33U);
  EXPECT_EQ(ends.graph.edges[31].from.index, 20);
  EXPECT_EQ(ends.graph.edges[31].to.index, 10);
  options.interval_all = true;
  EXPECT_EQ(map_of(drive, options).graph.edges.size(), 30U + 3U * 9U);
  options.node_distance_m = 0.35;
  options.node_angle_rad = 0.3;
  const MapResult sparse = map_of(drive, options);
  EXPECT_LT(sparse.graph.poses.size(), 15U);
  EXPECT_EQ(sparse.trajectory.size(), 31U);
  EXPECT_LT(error_m(sparse.trajectory, drive.truth), 0.05);
}

TEST(ScanToScan, GivesTheSameBytesWithAnyNumberOfThreads) {
  const RoomDrive drive = drive_about_the_room(true, 40);
  const MapResult one = map_of(drive, {}, {1});
  const MapResult four = map_of(drive, {}, {4});
  EXPECT_EQ(one.graph.poses, four.graph.poses);
  EXPECT_EQ(one.map.log_odds.cells(), four.map.log_odds.cells());
  ASSERT_EQ(one.graph.edges.size(), four.graph.edges.size());
  for (std::size_t i = 0; i < one.graph.edges.size(); ++i) {
    EXPECT_EQ(one.graph.edges[i].from_T_to, four.graph.edges[i].from_T_to);
    EXPECT_EQ(one.graph.edges[i].information, four.graph.edges[i].information);
  }
}

TEST(ScanToScan, StopsWhenAskedToAndSaysSo) {
  const RoomDrive drive = drive_about_the_room(true, 40);
  const MapResult stopped =
      map_of(drive, {}, {1}, [](const Progress& p) { return p.step != "matching intervals"; });
  EXPECT_FALSE(stopped.complete);
  EXPECT_EQ(stopped.trajectory.size(), 40U);
  const MapResult nothing = map_of(drive, {}, {1}, [](const Progress&) { return false; });
  EXPECT_FALSE(nothing.complete);
  EXPECT_TRUE(nothing.trajectory.empty());
}

TEST(ScanToScan, TakesLogsWithoutUsableScans) {
  RoomDrive drive = drive_about_the_room(true, 3);
  for (SensorMessage& message : drive.messages) {
    if (auto* scan = std::get_if<LaserScan>(&message)) {
      for (float& range : scan->ranges_m) range = std::numeric_limits<float>::quiet_NaN();
    }
  }
  const MapResult blind = map_of(drive);
  EXPECT_EQ(blind.statistics.scans, 3);
  EXPECT_EQ(blind.statistics.scans_dropped, 3);
  EXPECT_TRUE(blind.trajectory.empty());
  EXPECT_EQ(map_of({}).statistics.scans, 0);
  const MapResult single = map_of(drive_about_the_room(true, 1));
  EXPECT_EQ(single.trajectory.size(), 1U);
  EXPECT_FALSE(single.map.log_odds.empty());
}

TEST(ScanToScan, OdometryStandsInWhereScansDoNotMatch) {
  RoomDrive drive = drive_about_the_room(true, 30);
  // The lidar is covered by something near for one scan.
  auto& scan = std::get<LaserScan>(drive.messages[31]);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) scan.ranges_m[i] = 0.2F;
  const MapResult result = map_of(drive);
  EXPECT_EQ(result.warnings.size(), 1U);
  EXPECT_EQ(result.graph.edges[14].kind, EdgeKind::kOdometry);
  EXPECT_LT(error_m(result.trajectory, drive.truth), 0.05);
}

TEST(ScanEdges, InformationIsOfTheEdgesError) {
  // A motion that is well known along x of `from` is well known along -y of `to` after a left turn.
  PoseWithCovariance2 motion{{1.0, 0.0, 0.5 * kPi}, Eigen::Matrix3d::Zero()};
  motion.covariance.diagonal() << 0.01, 1.0, 0.04;
  const RelativePoseEdge edge = edge_between(3, 4, motion, EdgeKind::kMatch);
  EXPECT_NEAR(edge.information(1, 1), 100.0, 1e-9);
  EXPECT_NEAR(edge.information(0, 0), 1.0, 1e-9);
  EXPECT_NEAR(edge.information(2, 2), 25.0, 1e-9);
  const double off = 0.1;
  EXPECT_NEAR(edge_chi2(edge, {}, {1.0 + off, 0.0, 0.5 * kPi}), 100.0 * off * off, 1e-9);
}

TEST(ScanEdges, AMatchFarFromExpectationIsNotBelieved) {
  MatchResult match;
  match.covariance = 1e-4 * Eigen::Matrix3d::Identity();
  match.status = MatchStatus::kConverged;
  const PoseWithCovariance2 expected{{0.1, 0.0, 0.0}, 0.01 * Eigen::Matrix3d::Identity()};
  EXPECT_TRUE(believed(match, expected).has_value());
  match.target_T_source = {2.0, 0.0, 0.0};
  EXPECT_FALSE(believed(match, expected).has_value());
  match.target_T_source = {0.0, 0.0, 1.0};
  EXPECT_FALSE(believed(match, expected).has_value());
  match.target_T_source = {};
  match.status = MatchStatus::kNotConverged;
  EXPECT_FALSE(believed(match, expected).has_value());
}

TEST(ScanEdges, OdometryBoundsTheUncertaintyOfADegenerateMatch) {
  MatchResult match;
  match.covariance = 1e-4 * Eigen::Matrix3d::Identity();
  match.covariance(0, 0) = 100.0;
  match.status = MatchStatus::kDegenerate;
  const PoseWithCovariance2 expected{{0.0, 0.0, 0.0}, 0.01 * Eigen::Matrix3d::Identity()};
  const auto motion = believed(match, expected);
  ASSERT_TRUE(motion.has_value());
  EXPECT_NEAR(motion->covariance(0, 0), 0.01, 1e-3);
  EXPECT_LT(motion->covariance(1, 1), 2e-4);
}

}  // namespace
}  // namespace loopstone
