#pragma once

#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "loopstone/slam/mapped_scan.hpp"

namespace loopstone {

/// \param map_T_local  at the scan
[[nodiscard]] inline PosedScan posed(const MappedScan& mapped, const Pose2& map_T_local) {
  const Pose2 map_T_robot = map_T_local * mapped.local_T_robot;
  return {&mapped.scan, map_T_robot * mapped.robot_T_lidar,
          map_T_local * mapped.local_T_robot_end * mapped.robot_T_lidar, map_T_robot};
}

/// Of the robot during its sweep, its own frame [m/s, m/s, rad/s]; zero when that takes no time.
[[nodiscard]] inline Tangent2 sweep_velocity(const MappedScan& mapped) {
  const double sweep_s = sweep_seconds(mapped.scan);
  if (sweep_s == 0.0) return Tangent2::Zero();
  return log(mapped.local_T_robot.inverse() * mapped.local_T_robot_end) / sweep_s;
}

}  // namespace loopstone
