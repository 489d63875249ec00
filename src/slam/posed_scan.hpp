#pragma once

#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/slam/mapped_scan.hpp"

namespace loopstone {

/// \param map_T_local  at the scan
[[nodiscard]] inline PosedScan posed(const MappedScan& mapped, const Pose2& map_T_local) {
  const Pose2 map_T_robot = map_T_local * mapped.local_T_robot;
  return {&mapped.scan, map_T_robot * mapped.robot_T_lidar,
          map_T_local * mapped.local_T_robot_end * mapped.robot_T_lidar, map_T_robot};
}

}  // namespace loopstone
