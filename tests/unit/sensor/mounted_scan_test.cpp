#include "loopstone/sensor/mounted_scan.hpp"

#include <gtest/gtest.h>

#include <variant>

#include "loopstone/sensor/scan_points.hpp"

namespace loopstone {
namespace {

LaserScan quarter_scan() {
  LaserScan scan{
      .angle_min_rad = 0.0, .angle_increment_rad = 0.1, .range_min_m = 0.1, .range_max_m = 10.0};
  scan.ranges_m = {1.0F, 2.0F, 3.0F, 4.0F};
  return scan;
}

TEST(MountedScan, ARobotThatSaysNothingChangesNothing) {
  EXPECT_FALSE(as_mounted(quarter_scan(), RobotModel{}));
  EXPECT_FALSE(as_mounted(SensorMessage(quarter_scan()), RobotModel{}));
  EXPECT_FALSE(as_mounted(SensorMessage(WheelTicks{}), RobotModel{}));
}

TEST(MountedScan, UpsideDownLeftIsRight) {
  RobotModel robot;
  robot.lidars[0].upside_down = true;
  const auto mounted = as_mounted(quarter_scan(), robot);
  ASSERT_TRUE(mounted);
  const auto as_told = scan_points(quarter_scan(), Pose2{});
  const auto as_it_is = scan_points(*mounted, Pose2{});
  ASSERT_EQ(as_it_is.size(), as_told.size());
  for (std::size_t i = 0; i < as_told.size(); ++i) {
    EXPECT_NEAR(as_it_is[i].x(), as_told[i].x(), 1e-12);
    EXPECT_NEAR(as_it_is[i].y(), -as_told[i].y(), 1e-12);
  }
}

TEST(MountedScan, ASweepIsTakenWhereTheScanTellsNone) {
  RobotModel robot;
  robot.lidars[0].sweep_s = -0.08;
  const auto mounted = as_mounted(quarter_scan(), robot);
  ASSERT_TRUE(mounted);
  EXPECT_NEAR(sweep_seconds(*mounted), -0.08, 1e-12);
  LaserScan told = quarter_scan();
  told.time_increment_s = 0.001;
  EXPECT_FALSE(as_mounted(told, robot));
}

TEST(MountedScan, OtherLasersStayAsTheyAre) {
  RobotModel robot;
  robot.lidars[0].upside_down = true;
  LaserScan other = quarter_scan();
  other.lidar = 1;
  EXPECT_FALSE(as_mounted(other, robot));
  const auto message = as_mounted(SensorMessage(quarter_scan()), robot);
  ASSERT_TRUE(message);
  EXPECT_LT(std::get<LaserScan>(*message).angle_increment_rad, 0.0);
}

}  // namespace
}  // namespace loopstone
