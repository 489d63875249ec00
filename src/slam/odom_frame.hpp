#pragma once

#include <cmath>
#include <optional>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// The frame in which a controller may drive: it goes on with the robot and never jumps. The front
/// end's local frame does, when a robot that was lost is found somewhere else; then the difference
/// goes into local_T_odom.
class OdomFrame {
 public:
  /// \param guess      where the robot was expected, local frame
  /// \param may_jump   the pose was looked for, and not only refined
  /// \return odom_T_robot
  Pose2 follow(const Pose2& local_T_robot, const Pose2& guess, bool may_jump) {
    const Pose2 before = last_local_T_robot_.value_or(local_T_robot);
    const Pose2 moved = before.inverse() * local_T_robot;
    const Pose2 expected = before.inverse() * guess;
    if (may_jump && size_of(moved) > size_of(expected)) {
      // As far as expected, and no farther.
      const Pose2 odom_T_robot = local_T_odom_.inverse() * guess;
      local_T_odom_ = local_T_robot * odom_T_robot.inverse();
    }
    last_local_T_robot_ = local_T_robot;
    return local_T_odom_.inverse() * local_T_robot;
  }

  [[nodiscard]] const Pose2& local_T_odom() const { return local_T_odom_; }

  template <typename Archive>
  void archive(Archive& a) {
    a(last_local_T_robot_, local_T_odom_);
  }

 private:
  /// Turning is worth as much as the way of a point a metre off.
  [[nodiscard]] static double size_of(const Pose2& motion) {
    return std::hypot(motion.x, motion.y) + std::abs(wrap_angle(motion.yaw));
  }

  std::optional<Pose2> last_local_T_robot_{};
  Pose2 local_T_odom_{};
};

}  // namespace loopstone
