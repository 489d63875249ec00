#include "loopstone/formats/robot_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "formats/atomic_file.hpp"
#include "formats/toml_values.hpp"

namespace loopstone {

namespace {

struct RollPitchYaw {
  double roll_rad = 0.0;
  double pitch_rad = 0.0;
  double yaw_rad = 0.0;
};

/// To 1e-12 rad, so that 0.36 rad is written as 0.36 after its way through a quaternion.
double tidy(double angle_rad) { return std::round(angle_rad * 1e12) / 1e12 + 0.0; }

RollPitchYaw roll_pitch_yaw(const Eigen::Quaterniond& rotation) {
  const Eigen::Matrix3d r = rotation.toRotationMatrix();
  return {tidy(std::atan2(r(2, 1), r(2, 2))), tidy(std::asin(std::clamp(-r(2, 0), -1.0, 1.0))),
          tidy(std::atan2(r(1, 0), r(0, 0)))};
}

const Range kAngle{-2.0 * kPi, 2.0 * kPi};
const Range kMount{-100.0, 100.0};

/// Describes a robot's fields to a visitor, as visit_options does for options.
template <typename Visitor>
void visit_robot(RobotModel& robot, RollPitchYaw& camera_angles, Visitor&& visit) {
  visit("name", robot.name, OneOf{}, "for people");
  visit("footprint_radius_m", robot.footprint_radius_m, Range{0.0, 10.0},
        "cells this near to the robot's path are free [m]");

  visit("wheels.metres_per_count", robot.wheels.metres_per_count, Range{1e-9, 10.0},
        "how far a wheel rolls for each encoder count [m]");
  visit("wheels.track_width_m", robot.wheels.track_width_m, Range{0.001, 20.0},
        "effective distance of the left from the right wheels, for turning [m]");
  visit("wheels.counts_are_cumulative", robot.wheels.counts_are_cumulative,
        "counts since the start (true) or since the last reading (false)");
  visit("wheels.counter_bits", robot.wheels.counter_bits, Range{1, 62},
        "cumulative counters wrap at 2 to this power");

  for (std::size_t i = 0; i < robot.lidars.size(); ++i) {
    LidarMount& lidar = robot.lidars[i];
    const std::string prefix = fmt::format("lidars[{}].", i);
    visit(prefix + "name", lidar.name, OneOf{}, "for people");
    visit(prefix + "x_m", lidar.robot_T_lidar.x, kMount, "ahead of the robot's centre [m]");
    visit(prefix + "y_m", lidar.robot_T_lidar.y, kMount, "left of the robot's centre [m]");
    visit(prefix + "yaw_rad", lidar.robot_T_lidar.yaw, kAngle,
          "where its x axis points, counter-clockwise [rad]");
    visit(prefix + "height_m", lidar.height_m, kMount, "above the floor [m]");
  }

  CameraModel& camera = robot.camera;
  visit("camera.x_m", camera.robot_T_camera.translation.x(), kMount,
        "ahead of the robot's centre [m]");
  visit("camera.y_m", camera.robot_T_camera.translation.y(), kMount,
        "left of the robot's centre [m]");
  visit("camera.z_m", camera.robot_T_camera.translation.z(), kMount, "above the floor [m]");
  visit("camera.roll_rad", camera_angles.roll_rad, kAngle, "about the x axis [rad]");
  visit("camera.pitch_rad", camera_angles.pitch_rad, kAngle,
        "about the y axis; positive looks down [rad]");
  visit("camera.yaw_rad", camera_angles.yaw_rad, kAngle,
        "about the z axis; positive looks left [rad]");
  visit("camera.focal_x_px", camera.depth.focal_x_px, Range{1.0, 100000.0},
        "focal length, columns [px]");
  visit("camera.focal_y_px", camera.depth.focal_y_px, Range{1.0, 100000.0},
        "focal length, rows [px]");
  visit("camera.centre_x_px", camera.depth.centre_x_px, Range{-100000.0, 100000.0},
        "column of the optical axis [px]");
  visit("camera.centre_y_px", camera.depth.centre_y_px, Range{-100000.0, 100000.0},
        "row of the optical axis [px]");
  visit("camera.width_px", camera.depth.width_px, Range{1, 100000}, "columns of a picture [px]");
  visit("camera.height_px", camera.depth.height_px, Range{1, 100000}, "rows of a picture [px]");
}

std::vector<OptionEntry> list_robot(RobotModel& robot, RollPitchYaw& camera_angles) {
  std::vector<OptionEntry> entries;
  visit_robot(robot, camera_angles, OptionLister(entries));
  return entries;
}

}  // namespace

RobotModel parse_robot(std::string_view toml, const std::string& path) {
  TomlDocument document = parse_toml(toml, path);
  RobotModel robot;
  if (const auto lidars = document.table_arrays.find("lidars");
      lidars != document.table_arrays.end()) {
    robot.lidars.assign(lidars->second, LidarMount{});
  }
  // `lidars = []`: a robot without a lidar is a robot.
  const auto none = std::find_if(document.values.begin(), document.values.end(), [](const auto& v) {
    return v.key == "lidars" && (v.text == "[]" || v.text == "[ ]");
  });
  if (none != document.values.end()) {
    robot.lidars.clear();
    document.values.erase(none);
  }
  RollPitchYaw camera_angles = roll_pitch_yaw(robot.camera.robot_T_camera.rotation);
  std::vector<OptionProblem> problems =
      apply_values(list_robot(robot, camera_angles), document.values, path);
  problems.insert(problems.begin(), document.problems.begin(), document.problems.end());
  if (!problems.empty()) throw OptionsError(std::move(problems));

  for (LidarMount& lidar : robot.lidars) {
    lidar.robot_T_lidar.yaw = wrap_angle(lidar.robot_T_lidar.yaw);
  }
  robot.camera.robot_T_camera =
      Pose3::from_roll_pitch_yaw(robot.camera.robot_T_camera.translation, camera_angles.roll_rad,
                                 camera_angles.pitch_rad, camera_angles.yaw_rad);
  return robot;
}

RobotModel read_robot_file(const std::string& path) {
  return parse_robot(read_whole_file(path), path);
}

std::string robot_to_toml(const RobotModel& robot) {
  RobotModel copy = robot;
  RollPitchYaw camera_angles = roll_pitch_yaw(copy.camera.robot_T_camera.rotation);
  std::string text = "# A robot of Loopstone. x forward, y left, z up; metres, radians.\n";
  if (copy.lidars.empty()) text += "lidars = []\n";
  std::string group;
  for (const OptionEntry& entry : list_robot(copy, camera_angles)) {
    const auto dot = entry.key.find('.');
    const std::string own = dot == std::string::npos ? "" : entry.key.substr(0, dot);
    if (own != group) {
      const auto bracket = own.find('[');
      text += bracket == std::string::npos ? fmt::format("\n[{}]\n", own)
                                           : fmt::format("\n[[{}]]\n", own.substr(0, bracket));
      group = own;
    }
    const std::string field = dot == std::string::npos ? entry.key : entry.key.substr(dot + 1);
    text += fmt::format("{} = {}  # {}\n", field, toml_value(entry), entry.help);
  }
  return text;
}

}  // namespace loopstone
