#include "loopstone/registration/align.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "support/pose_near.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using test::pose_near;

RobotScan scan_from(const Pose2& pose) {
  Rng rng(7);
  return {test::scan_from(test::furnished_room(), pose, {}, {.noise_m = 0.005}, &rng)};
}

/// The room as cells of 5 cm, free inside.
Grid<std::int8_t> map_of_walls() {
  Grid<std::int8_t> map(GridFrame{{-1.0, -1.0}, 0.05, 200, 160}, std::int8_t{0});
  for (const test::Wall& wall : test::furnished_room()) {
    const Eigen::Vector2d along = wall.to - wall.from;
    for (double t = 0.0; t <= 1.0; t += 0.02 / along.norm()) {
      const Eigen::Vector2d at = wall.from + t * along;
      map[map.frame().cell_of(at)] = 100;
    }
  }
  return map;
}

std::vector<Eigen::Vector3d> bracket() {
  std::vector<Eigen::Vector3d> points;
  Rng rng(5);
  for (int i = 0; i < 500; ++i) {
    const double u = rng.uniform(0.0, 2.0);
    const double v = rng.uniform(0.0, 2.0);
    points.emplace_back(u, v, 0.0);
    points.emplace_back(u, 0.0, 0.6 * v);
    points.emplace_back(0.0, v, 0.8 * u);
    points.emplace_back(1.0 + 0.4 * u, 1.5 + 0.2 * v, 0.2 * u);
  }
  return points;
}

const Pose2 kTarget{3.0, 2.5, 0.3};
const Pose2 kSource{3.12, 2.58, 0.38};

TEST(Align, ScansWithoutAGuess) {
  const AlignResult<2> found = align(scan_from(kSource), scan_from(kTarget));
  EXPECT_EQ(found.match.status, MatchStatus::kConverged);
  EXPECT_EQ(found.method, "scans");
  EXPECT_TRUE(pose_near(found.match.target_T_source, kTarget.inverse() * kSource, 0.02, 0.01));
  EXPECT_GT(found.source.radius_m, 1.0);
}

TEST(Align, EveryMethodFindsTheMotionOfScans) {
  const Pose2 wanted = kTarget.inverse() * kSource;
  for (const auto& [method, name] : kWordTable<AlignMethod>) {
    AlignRequest<2> request;
    request.method = method;
    const AlignResult<2> found = align(scan_from(kSource), scan_from(kTarget), request);
    EXPECT_EQ(found.match.status, MatchStatus::kConverged) << name;
    EXPECT_TRUE(pose_near(found.match.target_T_source, wanted, 0.05, 0.02)) << name;
    EXPECT_EQ(found.method, method == AlignMethod::kAuto ? "scans" : name);
  }
}

/// Frames: poses are the robot's, wherever its laser sits.
TEST(Align, AMountedLaserTellsTheRobotsPose) {
  const Pose2 robot_T_lidar{0.3, -0.1, 0.7};
  const auto mounted = [&](const Pose2& map_T_robot) {
    RobotScan scan = scan_from(map_T_robot * robot_T_lidar);
    scan.robot_T_lidar = robot_T_lidar;
    return scan;
  };
  const AlignResult<2> found = align(mounted(kSource), mounted(kTarget));
  EXPECT_TRUE(pose_near(found.match.target_T_source, kTarget.inverse() * kSource, 0.02, 0.01));
  for (const bool from_a_guess : {true, false}) {
    AlignRequest<2> request;
    if (from_a_guess) request.guess = Pose2{kSource.x + 0.05, kSource.y - 0.05, kSource.yaw};
    const AlignResult<2> on_map = align(mounted(kSource), map_of_walls(), request);
    EXPECT_TRUE(pose_near(on_map.match.target_T_source, kSource, 0.04, 0.01)) << from_a_guess;
    EXPECT_EQ(on_map.method, from_a_guess ? "grid" : "correlative");
    EXPECT_EQ(on_map.map_match.has_value(), !from_a_guess);
  }
}

TEST(Align, OnAMapInAWindowAboutAWrongGuess) {
  AlignRequest<2> request;
  request.guess = Pose2{kSource.x + 0.8, kSource.y - 0.7, kSource.yaw + 0.9};
  request.search_xy_m = 1.5;
  request.search_yaw_rad = 1.2;
  const AlignResult<2> found = align(scan_from(kSource), map_of_walls(), request);
  EXPECT_EQ(found.match.status, MatchStatus::kConverged);
  EXPECT_TRUE(pose_near(found.match.target_T_source, kSource, 0.04, 0.01));
  EXPECT_EQ(found.guess.x, request.guess->x);
}

TEST(Align, PointsAreSearchedForWhereNoStartLeadsToAMatch) {
  const std::vector<Eigen::Vector3d> target = bracket();
  const Pose3 near = Pose3::from_roll_pitch_yaw({0.2, -0.1, 0.15}, 0.05, -0.04, 0.1);
  const Pose3 far = Pose3::from_roll_pitch_yaw({3.0, -2.0, 1.0}, 2.0, 0.7, -2.5);
  for (const bool is_far : {false, true}) {
    const Pose3& target_T_source = is_far ? far : near;
    std::vector<Eigen::Vector3d> source;
    for (const Eigen::Vector3d& p : target) source.push_back(target_T_source.inverse() * p);
    const AlignResult<3> found = align(source, target);
    EXPECT_EQ(found.match.status, MatchStatus::kConverged);
    EXPECT_LT((found.match.target_T_source.translation - target_T_source.translation).norm(), 0.01);
    EXPECT_EQ(found.method, is_far ? "search" : "icp_plane");
    EXPECT_EQ(found.search.has_value(), is_far);
  }
}

/// Millimetres or metres: without options, lengths are in proportion to the target.
TEST(Align, OptionsSuitTheTargetsSize) {
  const std::vector<Eigen::Vector3d> room = bracket();
  for (const double scale : {1.0, 1e-3, 50.0}) {
    const Pose3 motion =
        Pose3::from_roll_pitch_yaw(scale * Eigen::Vector3d(0.1, -0.1, 0.05), 0.02, -0.03, 0.05);
    std::vector<Eigen::Vector3d> target;
    std::vector<Eigen::Vector3d> source;
    for (const Eigen::Vector3d& p : room) target.emplace_back(scale * p);
    for (const Eigen::Vector3d& p : target) source.push_back(motion.inverse() * p);
    AlignRequest<3> request;
    request.guess.emplace();
    const AlignResult<3> found = align(source, target, request);
    EXPECT_EQ(found.match.status, MatchStatus::kConverged) << scale;
    EXPECT_LT((found.match.target_T_source.translation - motion.translation).norm(), 0.01 * scale);
  }
}

TEST(Align, ASweepTellsHowManyHeadingsAgree) {
  AlignRequest<2> request;
  request.method = AlignMethod::kIcpPlane;
  request.sweep_yaw = 12;
  const AlignResult<2> found = align(scan_from(kSource), scan_from(kTarget), request);
  ASSERT_TRUE(found.sweep);
  EXPECT_EQ(found.sweep->starts, 12);
  EXPECT_GE(found.sweep->agreeing, 1);
  EXPECT_LT(found.sweep->agreeing, 12) << "headings that are half a turn off can't end there";
}

TEST(Align, OneThreadAndManyGiveTheSameBytes) {
  const std::vector<Eigen::Vector3d> target = bracket();
  const Pose3 far = Pose3::from_roll_pitch_yaw({3.0, -2.0, 1.0}, 2.0, 0.7, -2.5);
  std::vector<Eigen::Vector3d> source;
  for (const Eigen::Vector3d& p : target) source.push_back(far * p);
  AlignRequest<3> request;
  request.anywhere = true;
  const AlignResult<3> one = align(source, target, request);
  request.threads = {4};
  const AlignResult<3> many = align(source, target, request);
  EXPECT_EQ(one.match.target_T_source.translation, many.match.target_T_source.translation);
  EXPECT_EQ(one.match.covariance, many.match.covariance);
}

TEST(Align, OnAMapPointsMeetTheWallsThatALaserSees) {
  Grid<std::int8_t> map(GridFrame{{1.0, 2.0}, 0.5, 4, 4}, std::int8_t{100});
  map[{0, 0}] = 0;
  // Seen from the free corner: the three cells that touch it.
  const std::vector<Eigen::Vector2d> walls = wall_points(map);
  ASSERT_EQ(walls.size(), 3U);
  EXPECT_EQ(walls[0], Eigen::Vector2d(1.75, 2.25));
  EXPECT_EQ(walls[2], Eigen::Vector2d(1.75, 2.75));
  AlignRequest<2> request;
  request.guess = Pose2{kSource.x + 0.03, kSource.y - 0.03, kSource.yaw};
  for (const AlignMethod method : {AlignMethod::kIcpPlane, AlignMethod::kGicp}) {
    request.method = method;
    const AlignResult<2> found = align(scan_from(kSource), map_of_walls(), request);
    EXPECT_TRUE(pose_near(found.match.target_T_source, kSource, 0.06, 0.02)) << to_string(method);
  }
}

TEST(Align, RefusesWhatDoesNotGoTogether) {
  const std::vector<Eigen::Vector2d> flat{{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}};
  const std::vector<Eigen::Vector3d> deep = bracket();
  const auto of = [](AlignMethod method) {
    AlignRequest<2> request;
    request.method = method;
    return request;
  };
  EXPECT_THROW((void)align(flat, flat, of(AlignMethod::kGrid)), UsageError);
  AlignRequest<2> window = of(AlignMethod::kIcpPlane);
  window.search_xy_m = 1.0;
  EXPECT_THROW((void)align(flat, flat, window), UsageError);
  AlignRequest<2> sweep = of(AlignMethod::kCorrelative);
  sweep.sweep_yaw = 3;
  EXPECT_THROW((void)align(flat, flat, sweep), UsageError);
  for (const AlignMethod method :
       {AlignMethod::kGrid, AlignMethod::kCorrelative, AlignMethod::kIcpLine}) {
    AlignRequest<3> request;
    request.method = method;
    EXPECT_THROW((void)align(deep, deep, request), UsageError);
  }
}

}  // namespace
}  // namespace loopstone
