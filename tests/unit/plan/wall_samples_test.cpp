#include "loopstone/plan/wall_samples.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "plan_scene.hpp"

namespace loopstone::test {
namespace {

constexpr double kHalf = 2.0;  // of a room's sides; its middle is the map's origin

/// What a laser at a pose sees of the room.
LaserScan scan_at(const Pose2& map_T_lidar, Stamp stamp) {
  constexpr int kBeams = 720;
  LaserScan scan{.stamp = stamp,
                 .angle_min_rad = -kPi,
                 .angle_increment_rad = 2.0 * kPi / kBeams,
                 .range_min_m = 0.05,
                 .range_max_m = 30.0};
  for (int beam = 0; beam < kBeams; ++beam) {
    const double yaw = map_T_lidar.yaw + scan.angle_rad(static_cast<std::size_t>(beam));
    double range = std::numeric_limits<double>::infinity();
    for (const auto& [at, way] :
         {std::pair{map_T_lidar.x, std::cos(yaw)}, std::pair{map_T_lidar.y, std::sin(yaw)}}) {
      if (way > 1e-9) range = std::min(range, (kHalf - at) / way);
      if (way < -1e-9) range = std::min(range, (-kHalf - at) / way);
    }
    scan.ranges_m.push_back(static_cast<float>(range));
  }
  return scan;
}

/// A robot that turns and moves in the room, and how its laser sits.
struct Drive {
  std::vector<MappedScan> scans{};
  Trajectory map_T_robot{};

  explicit Drive(const Pose2& robot_T_lidar) {
    for (int i = 0; i < 8; ++i) {
      const Stamp stamp = Stamp::from_seconds(100.0 + i);
      const Pose2 robot{0.1 * i - 0.4, 0.05 * i, 0.4 * i - 1.0};
      map_T_robot.append(stamp, robot);
      scans.push_back({.scan = scan_at(robot * robot_T_lidar, stamp),
                       .index = static_cast<std::size_t>(i),
                       .robot_T_lidar = robot_T_lidar});
    }
  }
  [[nodiscard]] std::vector<const MappedScan*> pointers() const {
    std::vector<const MappedScan*> all;
    for (const MappedScan& scan : scans) all.push_back(&scan);
    return all;
  }
};

Grid<std::int8_t> room_cells() {
  return PlanScene({-kHalf, -kHalf, 0.0}).rectangle(2.0 * kHalf, 2.0 * kHalf).cells();
}

/// Of samples from the nearest wall, rms: at a corner a normal is of two walls.
double off_m(const WallSamples& samples) {
  double sum = 0.0;
  for (const WallSample& sample : samples.samples) {
    const Eigen::Vector2d at = samples.origin + sample.point.cast<double>();
    sum += std::pow(at.cwiseAbs().maxCoeff() - kHalf, 2);
  }
  return std::sqrt(sum / static_cast<double>(samples.samples.size()));
}

TEST(SamplesOfScans, LieOnTheWallsAndFaceTheRoom) {
  const Drive drive({0.2, -0.1, 0.3});
  const WallSamples samples = samples_of_scans(drive.pointers(), drive.map_T_robot, room_cells());
  EXPECT_TRUE(samples.from_scans);
  EXPECT_GT(samples.samples.size(), 1000U);
  EXPECT_LT(off_m(samples), 0.005);
  for (const WallSample& sample : samples.samples) {
    const Eigen::Vector2d at = samples.origin + sample.point.cast<double>();
    EXPECT_LT(at.dot(sample.normal.cast<double>()), 0.0);
  }
}

TEST(SamplesOfScans, FollowAMountThatWasCorrected) {
  // The laser was taken to look straight on; the finished path is of the true centre.
  const Pose2 told{0.2, 0.0, 0.0};
  const Pose2 truth{0.15, 0.02, 0.03};
  Drive drive(truth);
  for (MappedScan& scan : drive.scans) scan.robot_T_lidar = told;
  const auto all = drive.pointers();
  EXPECT_GT(off_m(samples_of_scans(all, drive.map_T_robot, room_cells())), 0.02);
  EXPECT_LT(
      off_m(samples_of_scans(all, drive.map_T_robot, room_cells(), {}, truth * told.inverse())),
      0.005);
}

TEST(SamplesOfScans, LeaveOutWhatTheMapHasNot) {
  const Drive drive({});
  const std::size_t all =
      samples_of_scans(drive.pointers(), drive.map_T_robot, room_cells()).samples.size();
  // A wall that an edit erased.
  Grid<std::int8_t> cells = room_cells();
  for (int row = 0; row < cells.frame().rows; ++row)
    for (int column = 0; column < cells.frame().columns; ++column)
      if (cells.frame().centre_of({column, row}).x() > kHalf - 0.3) cells[{column, row}] = -1;
  const WallSamples fewer = samples_of_scans(drive.pointers(), drive.map_T_robot, cells);
  EXPECT_LT(fewer.samples.size(), all);
  for (const WallSample& sample : fewer.samples)
    EXPECT_LT((fewer.origin + sample.point.cast<double>()).x(), kHalf - 0.2);
  // Scans of another run.
  const Trajectory other({{Stamp::from_seconds(5.0), Pose2{}}});
  EXPECT_TRUE(samples_of_scans(drive.pointers(), other, room_cells()).samples.empty());
}

TEST(SamplesOfScansThreads, AreTheSameForAnyNumber) {
  const Drive drive({0.2, -0.1, 0.3});
  const WallSamples one =
      samples_of_scans(drive.pointers(), drive.map_T_robot, room_cells(), Threads{1});
  const WallSamples four =
      samples_of_scans(drive.pointers(), drive.map_T_robot, room_cells(), Threads{4});
  ASSERT_EQ(one.samples.size(), four.samples.size());
  for (std::size_t i = 0; i < one.samples.size(); ++i) {
    EXPECT_EQ(one.samples[i].point, four.samples[i].point);
    EXPECT_EQ(one.samples[i].scan, four.samples[i].scan);
  }
}

TEST(WallsByHand, AreMetFromWhereTheMapIsFree) {
  // A wall of 20 cm along the edge of what was seen: only its lower side is a surface.
  Grid<std::int8_t> cells({.origin = {-1.0, -1.0}, .resolution = 0.1, .columns = 40, .rows = 40});
  for (int row = 0; row < 40; ++row) {
    for (int column = 0; column < 40; ++column)
      cells[{column, row}] = static_cast<std::int8_t>(row < 20 ? 0 : row < 22 ? 100 : -1);
  }
  const Polygon2 wall = box_polygon({0.0, 1.0}, {2.0, 1.2});
  for (const bool turned : {false, true}) {
    Polygon2 polygon = wall;
    if (turned) std::reverse(polygon.corners.begin(), polygon.corners.end());
    WallSamples samples{.origin = {-1.0, -1.0}, .from_scans = true};
    add_walls({&polygon, 1}, cells, samples);
    ASSERT_GE(samples.samples.size(), 3U * 60U);
    for (const WallSample& sample : samples.samples) {
      EXPECT_NEAR(sample.point.y(), 2.0F, 1e-5F);
      EXPECT_NEAR(sample.normal.y(), -1.0F, 1e-5F);
      EXPECT_LE(sample.point.x(), 3.0F + 1e-5F);
    }
  }
}

}  // namespace
}  // namespace loopstone::test
