#pragma once

#include <vector>

#include "loopstone/odometry/trajectory.hpp"

namespace loopstone {

/// How the robot moved, averaged over equal spans of time; spans without a pose are left out.
struct MotionProfile {
  std::vector<double> time_s{};     ///< middle of each span, from the start of the trajectory
  std::vector<double> speed_m_s{};  ///< forward positive
  std::vector<double> yaw_rate_rad_s{};
};

/// Displacement and turn between consecutive poses, shared among the spans that they fall in.
[[nodiscard]] MotionProfile motion_profile(const Trajectory& trajectory, int most_spans);

}  // namespace loopstone
