#pragma once

#include <Eigen/Core>
#include <vector>

#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

struct SearchWindow;

/// How a reach is searched.
struct UntoldReachNumbers {
  double slice_rad = 0.2;
  double carried_slice_rad = 0.35;
};
inline constexpr UntoldReachNumbers kUntoldReach{};

template <typename Visitor>
void visit_numbers(const UntoldReachNumbers& n, Visitor&& visit) {
  visit("slice_rad", n.slice_rad,
        "chosen: half of what is searched at once where turns swing the robot far: 2 m after 10 m");
  visit("carried_slice_rad", n.carried_slice_rad,
        "derived: of a robot that was carried, places that face elsewhere are looked for by "
        "themselves: elsewhere_rad of the front end");
}

/// Where a robot may be that drove for a time of which nothing is told, and before and after it as
/// odometry tells: frame_T_robot = frame_T_start * the motion of that time * after. A turn that
/// nobody saw swings the way that was told since.
struct UntoldReach {
  Pose2 frame_T_start{};      ///< where odometry fell silent
  double ahead_m = 0.0;       ///< the middle of what it may have driven
  double half_xy_m = 0.0;     ///< how far from there it may have come
  double half_yaw_rad = 0.0;  ///< and turned
  double sigma_m = 0.0;       ///< standard deviations of the same
  double sigma_rad = 0.0;
  Pose2 after{};            ///< what was told since
  bool is_carried = false;  ///< by somebody: it did not drive

  /// The motion that nobody saw, from its middle.
  [[nodiscard]] Pose2 untold(const Pose2& frame_T_robot) const;
  [[nodiscard]] bool holds(const Pose2& frame_T_robot) const;
  /// Of (x, y, yaw) in the frame, at a pose.
  /// \param turn_rad  standard deviation of the turn that nobody saw
  [[nodiscard]] Eigen::Matrix3d covariance(const Pose2& frame_T_robot, double turn_rad) const;
  /// Windows that together cover it, the straight one in the middle: by turns, where these swing
  /// the robot far, or where somebody carried it.
  [[nodiscard]] std::vector<SearchWindow> windows() const;
};

/// The same in another frame.
[[nodiscard]] UntoldReach operator*(const Pose2& other_T_frame, UntoldReach reach);

}  // namespace loopstone
