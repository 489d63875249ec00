#include "loopstone/formats/robot_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/options_file.hpp"

namespace loopstone {
namespace {

using testing::HasSubstr;

void expect_same(const RobotModel& a, const RobotModel& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.footprint_radius_m, b.footprint_radius_m);
  EXPECT_EQ(a.wheels.metres_per_count, b.wheels.metres_per_count);
  EXPECT_EQ(a.wheels.track_width_m, b.wheels.track_width_m);
  EXPECT_EQ(a.wheels.counts_are_cumulative, b.wheels.counts_are_cumulative);
  EXPECT_EQ(a.wheels.counter_bits, b.wheels.counter_bits);
  ASSERT_EQ(a.lidars.size(), b.lidars.size());
  for (std::size_t i = 0; i < a.lidars.size(); ++i) {
    EXPECT_EQ(a.lidars[i].name, b.lidars[i].name);
    EXPECT_EQ(a.lidars[i].robot_T_lidar, b.lidars[i].robot_T_lidar);
    EXPECT_EQ(a.lidars[i].height_m, b.lidars[i].height_m);
  }
  EXPECT_EQ(a.camera.robot_T_camera.translation, b.camera.robot_T_camera.translation);
  EXPECT_LT(a.camera.robot_T_camera.rotation.angularDistance(b.camera.robot_T_camera.rotation),
            1e-7);
  EXPECT_EQ(a.camera.depth.focal_x_px, b.camera.depth.focal_x_px);
  EXPECT_EQ(a.camera.depth.focal_y_px, b.camera.depth.focal_y_px);
  EXPECT_EQ(a.camera.depth.centre_x_px, b.camera.depth.centre_x_px);
  EXPECT_EQ(a.camera.depth.centre_y_px, b.camera.depth.centre_y_px);
  EXPECT_EQ(a.camera.depth.width_px, b.camera.depth.width_px);
  EXPECT_EQ(a.camera.depth.height_px, b.camera.depth.height_px);
}

TEST(RobotFile, TheShippedRobotIsTheDefaultOne) {
  const std::string path = std::string(LOOPSTONE_SOURCE_DIR) + "/robots/ucsd.toml";
  expect_same(read_robot_file(path), RobotModel{});
}

TEST(RobotFile, WhatIsWrittenReadsBackTheSame) {
  RobotModel robot;
  robot.name = "a \"quoted\" robot \\ \n of two lines";
  robot.wheels.metres_per_count = 1.0 / 3.0;
  robot.wheels.counts_are_cumulative = true;
  robot.lidars = {{"front", {0.2, -0.1, 0.5}, 0.4}, {"rear", {-0.2, 0.0, 3.0}, 0.3}};
  robot.camera.robot_T_camera = Pose3::from_roll_pitch_yaw({1.0, 2.0, 3.0}, 0.1, -0.2, 2.5);
  const std::string toml = robot_to_toml(robot);
  expect_same(parse_robot(toml, "r.toml"), robot);
  EXPECT_EQ(robot_to_toml(parse_robot(toml, "r.toml")), toml);
}

TEST(RobotFile, NamedLidarsReplaceTheDefaultOnes) {
  EXPECT_EQ(parse_robot("", "r").lidars.size(), 1u);
  EXPECT_EQ(parse_robot("lidars = []", "r").lidars.size(), 0u);
  const RobotModel two = parse_robot("[[lidars]]\n[[lidars]]\nx_m = -0.3\n", "r");
  ASSERT_EQ(two.lidars.size(), 2u);
  EXPECT_EQ(two.lidars[1].robot_T_lidar.x, -0.3);
  RobotModel none;
  none.lidars.clear();
  EXPECT_EQ(parse_robot(robot_to_toml(none), "r").lidars.size(), 0u);
}

TEST(RobotFile, AllProblemsComeAtOnce) {
  try {
    (void)parse_robot("[wheels]\ntrack_with_m = 0.4\nmetres_per_count = -1\n[[lidars]]\nx = 3\n",
                      "r");
    FAIL() << "accepted";
  } catch (const OptionsError& error) {
    EXPECT_EQ(error.problems().size(), 3u);
    EXPECT_THAT(error.what(), HasSubstr("did you mean wheels.track_width_m?"));
    EXPECT_THAT(error.what(), HasSubstr("r:3: wheels.metres_per_count = -1"));
    EXPECT_THAT(error.what(), HasSubstr("r:5: lidars[0].x"));
  }
  EXPECT_THROW((void)parse_robot("\"lidars[99999999]\" = 1", "r"), OptionsError);
  EXPECT_THROW((void)read_robot_file("/no/such/robot.toml"), DataError);
}

}  // namespace
}  // namespace loopstone
