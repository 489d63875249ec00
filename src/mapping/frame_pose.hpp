#pragma once

#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// Where a frame was taken: the robot at the stamps of its two pictures, and how it moved.
struct FramePose {
  Pose2 map_T_robot_depth;
  Pose2 map_T_robot_colour;
  double speed_m_s = 0.0;
  double yaw_rate_rad_s = 0.0;
};

}  // namespace loopstone
