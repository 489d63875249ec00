#include "loopstone/formats/robot_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/atomic_file.hpp"
#include "formats/toml_values.hpp"
#include "loopstone/sensor/mounted_scan.hpp"

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
const Range kMount{-kFarthestMountM, kFarthestMountM};

/// The rotations of a robot as angles, which is how people write them.
struct CameraAngles {
  RollPitchYaw camera{};
  RollPitchYaw colour{};
};

CameraAngles angles_of(const CameraModel& camera) {
  return {roll_pitch_yaw(camera.robot_T_camera.rotation),
          roll_pitch_yaw(camera.camera_T_colour.rotation)};
}

Pose3 posed(const Eigen::Vector3d& translation, const RollPitchYaw& angles) {
  return Pose3::from_roll_pitch_yaw(translation, angles.roll_rad, angles.pitch_rad, angles.yaw_rad);
}

template <typename Visitor>
void visit_mount(const std::string& prefix, const std::string& relative_to,
                 Eigen::Vector3d& translation, RollPitchYaw& angles, Visitor& visit) {
  visit(prefix + "x_m", translation.x(), kMount, "ahead of " + relative_to + " [m]");
  visit(prefix + "y_m", translation.y(), kMount, "left of " + relative_to + " [m]");
  visit(prefix + "z_m", translation.z(), kMount, "above " + relative_to + " [m]");
  visit(prefix + "roll_rad", angles.roll_rad, kAngle, "about the x axis [rad]");
  visit(prefix + "pitch_rad", angles.pitch_rad, kAngle,
        "about the y axis; positive looks down [rad]");
  visit(prefix + "yaw_rad", angles.yaw_rad, kAngle, "about the z axis; positive looks left [rad]");
}

template <typename Visitor>
void visit_lens(const std::string& prefix, LensModel& lens, Visitor& visit) {
  const Range focal{1.0, 100000.0};
  const Range centre{-100000.0, 100000.0};
  const Range bend{-100.0, 100.0};
  visit(prefix + "width_px", lens.width_px, Range{1, 100000}, "columns of a picture [px]");
  visit(prefix + "height_px", lens.height_px, Range{1, 100000}, "rows of a picture [px]");
  visit(prefix + "focal_x_px", lens.focal_x_px, focal, "focal length, columns [px]");
  visit(prefix + "focal_y_px", lens.focal_y_px, focal, "focal length, rows [px]");
  visit(prefix + "centre_x_px", lens.centre_x_px, centre, "column of the optical axis [px]");
  visit(prefix + "centre_y_px", lens.centre_y_px, centre, "row of the optical axis [px]");
  visit(prefix + "k1", lens.k1, bend, "radial distortion, r^2 (as OpenCV orders them)");
  visit(prefix + "k2", lens.k2, bend, "radial distortion, r^4");
  visit(prefix + "p1", lens.p1, bend, "tangential distortion");
  visit(prefix + "p2", lens.p2, bend, "tangential distortion");
  visit(prefix + "k3", lens.k3, bend, "radial distortion, r^6");
}

template <typename Visitor>
void visit_camera(CameraModel& camera, CameraAngles& angles, Visitor& visit) {
  visit_mount("camera.", "the robot's centre on the floor", camera.robot_T_camera.translation,
              angles.camera, visit);
  visit_lens("camera.depth.", camera.depth, visit);
  visit_mount("camera.colour.", "the depth camera", camera.camera_T_colour.translation,
              angles.colour, visit);
  visit(
      "camera.colour.is_registered", camera.colour_is_registered,
      "colour pictures have the depth camera's pixels: lens and place of this table are not used");
  visit_lens("camera.colour.", camera.colour, visit);
  DepthEncoding& encoding = camera.encoding;
  const std::string prefix = "camera.encoding.";
  visit(prefix + "kind", encoding.kind,
        "what the 16-bit numbers of depth pictures are; 0 is no measurement");
  visit(prefix + "disparity_slope", encoding.disparity_slope, Range{-1000.0, 1000.0},
        "depth = numerator / (slope * number + offset)");
  visit(prefix + "disparity_offset", encoding.disparity_offset, Range{-1e6, 1e6},
        "of this formula");
  visit(prefix + "disparity_numerator_m", encoding.disparity_numerator_m, Range{1e-6, 1e6},
        "of this formula [m]");
  visit(prefix + "metres_per_unit", encoding.metres_per_unit, Range{1e-9, 1000.0},
        "of depth numbers [m]");
  visit(prefix + "range_min_m", encoding.range_min_m, Range{0.0, 1000.0},
        "nearer is no measurement [m]");
  visit(prefix + "range_max_m", encoding.range_max_m, Range{0.001, 10000.0},
        "farther is no measurement [m]");
}

/// Describes a robot's fields to a visitor, as visit_options does for options.
template <typename Visitor>
void visit_robot(RobotModel& robot, CameraAngles& angles, Visitor&& visit) {
  visit("name", robot.name, "for people");
  visit("footprint_radius_m", robot.footprint_radius_m, Range{0.0, 10.0},
        "cells this near to the robot's path are free [m]");

  visit("odometry_scale", robot.odometry_scale, Range{0.2, 5.0},
        "odometry's way / the real one, as another drive told it; 1: learned while driving");

  visit("wheels.metres_per_count", robot.wheels.metres_per_count, Range{1e-9, 10.0},
        "how far a wheel rolls for each encoder count [m]");
  visit("wheels.track_width_m", robot.wheels.track_width_m, Range{0.001, 20.0},
        "effective distance of the left from the right wheels, for turning [m]");
  visit("wheels.counts_are_cumulative", robot.wheels.counts_are_cumulative,
        "counts since the start (true) or since the last reading (false)");
  visit("wheels.counter_bits", robot.wheels.counter_bits, Range{1, 62},
        "cumulative counters wrap at 2 to this power");
  visit("wheels.radius_m", robot.wheels.radius_m, Range{0.001, 10.0},
        "of the wheels, where a recording tells their angles [m]");

  for (std::size_t i = 0; i < robot.lidars.size(); ++i) {
    LidarMount& lidar = robot.lidars[i];
    const std::string prefix = fmt::format("lidars[{}].", i);
    visit(prefix + "name", lidar.name, "for people");
    visit(prefix + "x_m", lidar.robot_T_lidar.x, kMount, "ahead of the robot's centre [m]");
    visit(prefix + "y_m", lidar.robot_T_lidar.y, kMount, "left of the robot's centre [m]");
    visit(prefix + "yaw_rad", lidar.robot_T_lidar.yaw, kAngle,
          "where its x axis points, counter-clockwise [rad]");
    visit(prefix + "height_m", lidar.height_m, kMount, "above the floor [m]");
    visit(prefix + "upside_down", lidar.upside_down,
          "its beams go round the other way than its scans say");
    visit(prefix + "sweep_s", lidar.sweep_s, Range{-kLongestSweepS, kLongestSweepS},
          "from the first beam to the last, where scans do not tell; negative: the last is first "
          "[s]");
  }
  visit_camera(robot.camera, angles, visit);
}

std::vector<OptionEntry> list_robot(RobotModel& robot, CameraAngles& angles) {
  std::vector<OptionEntry> entries;
  visit_robot(robot, angles, OptionLister(entries));
  return entries;
}

/// The lens once stood in [camera] itself: says where its keys are now.
std::vector<OptionProblem> take_moved_keys(TomlDocument& document, const std::string& path) {
  static constexpr std::array<std::string_view, 6> kMoved{
      "focal_x_px", "focal_y_px", "centre_x_px", "centre_y_px", "width_px", "height_px"};
  std::vector<OptionProblem> problems;
  std::erase_if(document.values, [&](const TomlValue& value) {
    for (const std::string_view name : kMoved) {
      if (value.key != fmt::format("camera.{}", name)) continue;
      const auto line = value.line > 0 ? std::optional(value.line) : std::nullopt;
      problems.push_back(
          {value.key,
           value.text,
           fmt::format("is now camera.depth.{0}; the colour camera's is camera.colour.{0}", name),
           {path, line, {}}});
      return true;
    }
    return false;
  });
  return problems;
}

/// What no single key can tell.
std::vector<OptionProblem> check_camera(const CameraModel& camera, const std::string& path) {
  std::vector<OptionProblem> problems;
  const DepthEncoding& encoding = camera.encoding;
  if (encoding.range_min_m >= encoding.range_max_m) {
    problems.push_back({"camera.encoding.range_min_m",
                        toml_number(encoding.range_min_m),
                        "must be less than camera.encoding.range_max_m",
                        {path, {}, {}}});
  }
  if (encoding.kind == DepthKind::kDisparity && encoding.disparity_slope == 0.0) {
    problems.push_back({"camera.encoding.disparity_slope",
                        "0.0",
                        "must not be 0: all disparities would mean the same depth",
                        {path, {}, {}}});
  }
  return problems;
}

/// Takes what the key states of the wheels, if it is of them.
void state(StatedWheels& stated, std::string_view key, const WheelModel& wheels) {
  if (key == "wheels.metres_per_count") stated.metres_per_count = wheels.metres_per_count;
  if (key == "wheels.radius_m") stated.radius_m = wheels.radius_m;
  if (key == "wheels.track_width_m") stated.track_width_m = wheels.track_width_m;
  if (key == "wheels.counts_are_cumulative")
    stated.counts_are_cumulative = wheels.counts_are_cumulative;
  if (key == "wheels.counter_bits") stated.counter_bits = wheels.counter_bits;
}

void wrap_yaws(RobotModel& robot) {
  for (LidarMount& lidar : robot.lidars)
    lidar.robot_T_lidar.yaw = wrap_angle(lidar.robot_T_lidar.yaw);
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
  std::vector<OptionProblem> problems = take_moved_keys(document, path);
  CameraAngles angles = angles_of(robot.camera);
  for (const auto& found : {apply_values(list_robot(robot, angles), document.values, path),
                            check_camera(robot.camera, path)}) {
    problems.insert(problems.end(), found.begin(), found.end());
  }
  problems.insert(problems.begin(), document.problems.begin(), document.problems.end());
  if (!problems.empty()) throw OptionsError(std::move(problems));

  wrap_yaws(robot);
  CameraModel& camera = robot.camera;
  camera.robot_T_camera = posed(camera.robot_T_camera.translation, angles.camera);
  camera.camera_T_colour = posed(camera.camera_T_colour.translation, angles.colour);
  return robot;
}

RobotModel read_robot_file(const std::string& path) {
  return parse_robot(read_whole_file(path, kMostOptionBytes), path);
}

StatedWheels stated_wheels(std::string_view toml, const std::string& path) {
  const WheelModel wheels = parse_robot(toml, path).wheels;
  StatedWheels stated;
  for (const TomlValue& value : parse_toml(toml, path).values) state(stated, value.key, wheels);
  return stated;
}

StatedWheels read_stated_wheels(const std::string& path) {
  return stated_wheels(read_whole_file(path, kMostOptionBytes), path);
}

RobotModel changed_robot(RobotModel robot, const RobotValues& changes, const std::string& origin) {
  CameraAngles angles = angles_of(robot.camera);
  const std::vector<OptionEntry> entries = list_robot(robot, angles);
  std::vector<OptionProblem> problems;
  bool camera_turned = false;
  const auto add = [&](std::vector<OptionProblem> found) {
    for (OptionProblem& problem : found) {
      problem.where.path = origin;
      problems.push_back(std::move(problem));
    }
  };
  for (const auto& [key, value] : changes) {
    std::string assignment = key;
    add(apply_assignment(entries, assignment.append("=").append(value)));
    camera_turned = camera_turned || (key.starts_with("camera.") && key.ends_with("_rad"));
  }
  add(problems_of(entries));
  add(check_camera(robot.camera, origin));
  if (!problems.empty()) throw OptionsError(std::move(problems));

  wrap_yaws(robot);
  if (camera_turned) {
    CameraModel& camera = robot.camera;
    camera.robot_T_camera = posed(camera.robot_T_camera.translation, angles.camera);
    camera.camera_T_colour = posed(camera.camera_T_colour.translation, angles.colour);
  }
  return robot;
}

StatedWheels changed_stated_wheels(StatedWheels stated, const WheelModel& wheels,
                                   const RobotValues& changes) {
  for (const auto& [key, value] : changes) state(stated, key, wheels);
  return stated;
}

std::string robot_to_toml(const RobotModel& robot) {
  RobotModel copy = robot;
  CameraAngles angles = angles_of(copy.camera);
  std::string text = "# A robot of Loopstone. x forward, y left, z up; metres, radians.\n";
  if (copy.lidars.empty()) text += "lidars = []\n";
  std::string group;
  for (const OptionEntry& entry : list_robot(copy, angles)) {
    const auto dot = entry.key.rfind('.');
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
