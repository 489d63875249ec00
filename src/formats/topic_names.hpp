#pragma once

#include <string>

#include "formats/ros_geometry.hpp"
#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/messages/message_types.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/sensor/robot_model.hpp"

// What recordings that are written here call topics and frames. Frames are those of REP-105.

namespace loopstone {

inline constexpr const char* kMapFrame = "map";
inline constexpr const char* kOdometryFrame = "odom";
inline constexpr const char* kBaseFrame = "base_link";

/// "/scan", "/scan_2", "/scan_3".
[[nodiscard]] inline std::string numbered(const std::string& name, int lidar) {
  return lidar == 0 ? name : name + "_" + std::to_string(lidar + 1);
}
[[nodiscard]] inline std::string scan_topic(int lidar) { return numbered("/scan", lidar); }
[[nodiscard]] inline std::string laser_frame(int lidar) { return numbered("laser", lidar); }

[[nodiscard]] inline msg::Pose to_message(const Pose2& pose) {
  return {.position = {.x = pose.x, .y = pose.y}, .orientation = to_quaternion(pose.yaw)};
}

/// parent_T_child, at a height above the parent's origin.
[[nodiscard]] inline msg::TransformStamped transform_message(Stamp stamp, const std::string& parent,
                                                             const std::string& child,
                                                             const Pose2& pose,
                                                             double height_m = 0.0) {
  msg::TransformStamped transform{.header = {stamp, parent}, .child_frame_id = child};
  transform.transform.translation = {.x = pose.x, .y = pose.y, .z = height_m};
  transform.transform.rotation = to_quaternion(pose.yaw);
  return transform;
}

/// Where the laser of a scan sits on the robot.
[[nodiscard]] inline msg::TransformStamped mount_message(const LaserScan& scan,
                                                         const RobotModel& robot) {
  const auto index = static_cast<std::size_t>(scan.lidar);
  const double height_m = index < robot.lidars.size() ? robot.lidars[index].height_m : 0.0;
  return transform_message(scan.stamp, kBaseFrame, laser_frame(scan.lidar), mount_of(scan, robot),
                           height_m);
}

}  // namespace loopstone
