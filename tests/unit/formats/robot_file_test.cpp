#include "loopstone/formats/robot_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/options_file.hpp"
#include "source_folder.hpp"

namespace loopstone {
namespace {

using testing::HasSubstr;

void expect_same_pose(const Pose3& a, const Pose3& b) {
  EXPECT_EQ(a.translation, b.translation);
  EXPECT_LT(a.rotation.angularDistance(b.rotation), 1e-7);
}

void expect_same_lens(const LensModel& a, const LensModel& b) {
  EXPECT_EQ(a.focal_x_px, b.focal_x_px);
  EXPECT_EQ(a.focal_y_px, b.focal_y_px);
  EXPECT_EQ(a.centre_x_px, b.centre_x_px);
  EXPECT_EQ(a.centre_y_px, b.centre_y_px);
  EXPECT_EQ(a.width_px, b.width_px);
  EXPECT_EQ(a.height_px, b.height_px);
  EXPECT_EQ(a.k1, b.k1);
  EXPECT_EQ(a.k2, b.k2);
  EXPECT_EQ(a.p1, b.p1);
  EXPECT_EQ(a.p2, b.p2);
  EXPECT_EQ(a.k3, b.k3);
}

void expect_same(const RobotModel& a, const RobotModel& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.footprint_radius_m, b.footprint_radius_m);
  EXPECT_EQ(a.wheels.metres_per_count, b.wheels.metres_per_count);
  EXPECT_EQ(a.wheels.track_width_m, b.wheels.track_width_m);
  EXPECT_EQ(a.wheels.counts_are_cumulative, b.wheels.counts_are_cumulative);
  EXPECT_EQ(a.wheels.counter_bits, b.wheels.counter_bits);
  EXPECT_EQ(a.wheels.radius_m, b.wheels.radius_m);
  ASSERT_EQ(a.lidars.size(), b.lidars.size());
  for (std::size_t i = 0; i < a.lidars.size(); ++i) {
    EXPECT_EQ(a.lidars[i].name, b.lidars[i].name);
    EXPECT_EQ(a.lidars[i].robot_T_lidar, b.lidars[i].robot_T_lidar);
    EXPECT_EQ(a.lidars[i].height_m, b.lidars[i].height_m);
    EXPECT_EQ(a.lidars[i].upside_down, b.lidars[i].upside_down);
    EXPECT_EQ(a.lidars[i].sweep_s, b.lidars[i].sweep_s);
  }
  expect_same_pose(a.camera.robot_T_camera, b.camera.robot_T_camera);
  expect_same_pose(a.camera.camera_T_colour, b.camera.camera_T_colour);
  expect_same_lens(a.camera.depth, b.camera.depth);
  expect_same_lens(a.camera.colour, b.camera.colour);
  EXPECT_EQ(a.camera.colour_is_registered, b.camera.colour_is_registered);
  EXPECT_EQ(a.camera.encoding.kind, b.camera.encoding.kind);
  EXPECT_EQ(a.camera.encoding.disparity_slope, b.camera.encoding.disparity_slope);
  EXPECT_EQ(a.camera.encoding.disparity_offset, b.camera.encoding.disparity_offset);
  EXPECT_EQ(a.camera.encoding.disparity_numerator_m, b.camera.encoding.disparity_numerator_m);
  EXPECT_EQ(a.camera.encoding.metres_per_unit, b.camera.encoding.metres_per_unit);
  EXPECT_EQ(a.camera.encoding.range_min_m, b.camera.encoding.range_min_m);
  EXPECT_EQ(a.camera.encoding.range_max_m, b.camera.encoding.range_max_m);
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
  robot.wheels.radius_m = 1.0 / 30.0;
  robot.lidars = {{"front", {0.2, -0.1, 0.5}, 0.4, true, -0.025}, {"rear", {-0.2, 0.0, 3.0}, 0.3}};
  robot.camera.robot_T_camera = Pose3::from_roll_pitch_yaw({1.0, 2.0, 3.0}, 0.1, -0.2, 2.5);
  robot.camera.camera_T_colour = Pose3::from_roll_pitch_yaw({0.01, -0.02, 0.03}, 0.3, 0.2, -0.1);
  robot.camera.depth = {501.25, 502.5, 310.1, 240.2, 320, 240, 0.1, -0.2, 0.003, -0.004, 0.05};
  robot.camera.colour = {1.0 / 0.007, 602.5, 640.5, 512.25, 1280, 1024, -0.3, 0.4, -0.5, 0.6, -0.7};
  robot.camera.colour_is_registered = true;
  robot.camera.encoding = {DepthKind::kDepth, 0.125, 2.0, 7.5, 0.0001, 0.25, 6.5};
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

TEST(RobotFile, WhatIsSaidOfTheWheelsIsKnownFromWhatIsNot) {
  const StatedWheels none = stated_wheels("[[lidars]]\nx_m = 0.3\n", "r");
  EXPECT_FALSE(none.metres_per_count || none.radius_m || none.track_width_m);
  EXPECT_FALSE(none.counts_are_cumulative || none.counter_bits);
  const StatedWheels some = stated_wheels("[wheels]\nradius_m = 0.033\ntrack_width_m = 1\n", "r");
  EXPECT_EQ(some.radius_m, 0.033);
  EXPECT_EQ(some.track_width_m, 1.0);
  EXPECT_FALSE(some.metres_per_count);
  const StatedWheels all = stated_wheels(robot_to_toml({}), "r");
  EXPECT_EQ(all.metres_per_count, WheelModel{}.metres_per_count);
  EXPECT_EQ(all.counts_are_cumulative, false);
  EXPECT_EQ(all.counter_bits, 32);
  EXPECT_THROW((void)stated_wheels("[wheels]\nradius_m = -1\n", "r"), OptionsError);
  EXPECT_THROW((void)read_stated_wheels("/no/such/robot.toml"), DataError);
}

TEST(RobotFile, TheLensHasMovedAndTheMessageSaysWhere) {
  try {
    (void)parse_robot("[camera]\nfocal_x_px = 600.0\nwidth_px = 320\nx_m = 0.2\n", "r");
    FAIL() << "accepted";
  } catch (const OptionsError& error) {
    EXPECT_EQ(error.problems().size(), 2u);
    EXPECT_THAT(error.what(), HasSubstr("r:2: camera.focal_x_px = 600"));
    EXPECT_THAT(error.what(), HasSubstr("is now camera.depth.focal_x_px"));
    EXPECT_THAT(error.what(), HasSubstr("camera.colour.width_px"));
  }
}

TEST(RobotFile, ACameraThatCanNotMeasureIsRefused) {
  const auto refused = [](const std::string& toml, const std::string& part) {
    try {
      (void)parse_robot(toml, "r");
      FAIL() << toml;
    } catch (const OptionsError& error) {
      EXPECT_THAT(error.what(), HasSubstr(part));
    }
  };
  refused("[camera.encoding]\nkind = \"parallax\"", "one of disparity, depth");
  refused("[camera.encoding]\nrange_min_m = 11.0", "must be less than camera.encoding.range_max_m");
  refused("[camera.encoding]\ndisparity_slope = 0.0", "must not be 0");
  refused("[camera.depth]\nfocal_x_px = 0.0", "camera.depth.focal_x_px");
  refused("[camera.color]\nis_registered = true", "did you mean camera.colour.is_registered?");
}

TEST(RobotFile, ChangesWhatIsNamedAndKeepsTheRestToTheBit) {
  RobotModel robot;
  robot.lidars.push_back(LidarMount{.name = "rear"});
  const RobotValues changes{{"wheels.track_width_m", "0.5"}, {"lidars[1].yaw_rad", "4"}};
  const RobotModel changed = changed_robot(robot, changes, "r");
  RobotModel expected = robot;
  expected.wheels.track_width_m = 0.5;
  expected.lidars[1].robot_T_lidar.yaw = 4.0 - 2.0 * kPi;
  EXPECT_EQ(changed.camera.robot_T_camera.rotation.coeffs(),
            robot.camera.robot_T_camera.rotation.coeffs());
  expect_same(changed, expected);
  const StatedWheels stated = changed_stated_wheels({.radius_m = 0.1}, changed.wheels, changes);
  EXPECT_EQ(stated.track_width_m, 0.5);
  EXPECT_EQ(stated.radius_m, 0.1);
  EXPECT_FALSE(stated.metres_per_count);

  const RobotModel tilted = changed_robot(robot, {{"camera.pitch_rad", "0.5"}}, "r");
  EXPECT_GT(
      tilted.camera.robot_T_camera.rotation.angularDistance(robot.camera.robot_T_camera.rotation),
      0.1);
  robot.lidars[0].robot_T_lidar.x = 1e9;
  try {
    (void)changed_robot(robot, {{"wheels.track", "0.5"}, {"lidars[7].x_m", "0"}}, "r");
    FAIL() << "accepted";
  } catch (const OptionsError& error) {
    EXPECT_EQ(error.problems().size(), 3U);
    EXPECT_THAT(error.what(), HasSubstr("lidars[0].x_m"));
    EXPECT_THAT(error.what(), HasSubstr("r: wheels.track"));
  }
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
