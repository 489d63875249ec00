#pragma once

#include <string>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/camera_model.hpp"

namespace loopstone {

/// A differential (skid-steered) drive.
struct WheelModel {
  double metres_per_count = 0.0022;
  double track_width_m = 0.39;  ///< effective: distance between the two virtual wheels
  bool counts_are_cumulative = false;
  int counter_bits = 32;    ///< where cumulative counters wrap
  double radius_m = 0.127;  ///< of wheels that are told as angles
};

/// No sensor is mounted farther from its robot's centre, along an axis [m].
inline constexpr double kFarthestMountM = 100.0;

/// Where a planar lidar sits on the robot.
struct LidarMount {
  std::string name = "front";
  Pose2 robot_T_lidar{0.14, 0.0, 0.0};
  double height_m = 0.51435;
  bool upside_down = false;  ///< its beams go round the other way than its scans say
  /// From the first beam to the last where its scans do not tell; 0: all at once; negative: the
  /// last beam comes first.
  double sweep_s = 0.0;
};

/// What is fixed about a robot. The defaults describe the UCSD differential-drive robot.
struct RobotModel {
  std::string name = "ucsd";
  double footprint_radius_m = 0.25;  ///< cells this near to the robot's path are free
  WheelModel wheels{};
  /// Odometry's way / the real one, as another drive told it; 1: learned while driving.
  double odometry_scale = 1.0;
  std::vector<LidarMount> lidars{LidarMount{}};
  CameraModel camera{};
};

/// The mount of a scan's lidar: what the scan itself says, else the model's, else the robot's
/// centre.
template <typename Scan>
[[nodiscard]] Pose2 mount_of(const Scan& scan, const RobotModel& robot) {
  if (scan.robot_T_lidar) return *scan.robot_T_lidar;
  const auto index = static_cast<std::size_t>(scan.lidar);
  if (scan.lidar >= 0 && index < robot.lidars.size()) return robot.lidars[index].robot_T_lidar;
  return Pose2{};
}

}  // namespace loopstone
