#include "loopstone/slam/untold_reach.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "slam/scan_edges.hpp"

namespace loopstone {

Pose2 UntoldReach::untold(const Pose2& frame_T_robot) const {
  const Pose2 start_T_spoke = frame_T_start.inverse() * frame_T_robot * after.inverse();
  return Pose2{ahead_m, 0.0, 0.0}.inverse() * start_T_spoke;
}

bool UntoldReach::holds(const Pose2& frame_T_robot) const {
  const Pose2 motion = untold(frame_T_robot);
  return std::max(std::abs(motion.x), std::abs(motion.y)) <= half_xy_m &&
         std::abs(motion.yaw) <= half_yaw_rad;
}

Eigen::Matrix3d UntoldReach::covariance(const Pose2& frame_T_robot, double turn_rad) const {
  const Eigen::Vector2d arm =
      frame_T_robot.translation() - (frame_T_robot * after.inverse()).translation();
  const Eigen::Matrix3d lever = lever_of(arm);
  return lever * planar_covariance(sigma_m, turn_rad) * lever.transpose();
}

std::vector<SearchWindow> UntoldReach::windows() const {
  const double most_rad = std::min(half_yaw_rad, kPi);
  const double arm_m = after.translation().norm();
  const bool swings = arm_m * most_rad > half_xy_m;
  const double slice_rad = swings       ? kUntoldReach.slice_rad
                           : is_carried ? kUntoldReach.carried_slice_rad
                                        : most_rad;
  const double beside = 0.5 * (most_rad / slice_rad - 1.0);
  const int count = 2 * std::max(static_cast<int>(std::ceil(beside)), 0) + 1;
  const double half_slice_rad = most_rad / count;
  std::vector<SearchWindow> windows;
  for (int slice = 0; slice < count; ++slice) {
    const double turn_rad = (2 * slice + 1 - count) * half_slice_rad;
    windows.push_back({frame_T_start * Pose2{ahead_m, 0.0, turn_rad} * after,
                       half_xy_m + arm_m * std::min(half_slice_rad, 2.0), half_slice_rad});
  }
  return windows;
}

UntoldReach operator*(const Pose2& other_T_frame, UntoldReach reach) {
  reach.frame_T_start = other_T_frame * reach.frame_T_start;
  return reach;
}

}  // namespace loopstone
