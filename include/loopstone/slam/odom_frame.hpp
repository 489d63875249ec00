#pragma once

#include <cmath>
#include <optional>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/base/sound_state.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// What the frame to drive by decides by.
struct OdomFrameNumbers {
  double lever_m = 1.0;
};
inline constexpr OdomFrameNumbers kOdomFrame{};

template <typename Visitor>
void visit_numbers(const OdomFrameNumbers& n, Visitor&& visit) {
  visit("lever_m", n.lever_m,
        "chosen: turning is worth as much as the way of a point so far off: about a robot's size");
}

/// The frame in which a controller may drive: it goes on with the robot and never jumps. The front
/// end's local frame does, when a robot that was lost is found somewhere else; then the difference
/// goes into local_T_odom.
class OdomFrame {
 public:
  /// \param guess      where the robot was expected, local frame
  /// \param may_jump   the pose was looked for, and not only refined
  /// \return odom_T_robot
  Pose2 follow(const Pose2& local_T_robot, const Pose2& guess, bool may_jump) {
    const Pose2 before = state_.last_local_T_robot.value_or(local_T_robot);
    const Pose2 moved = before.inverse() * local_T_robot;
    const Pose2 expected = before.inverse() * guess;
    if (may_jump && size_of(moved) > size_of(expected)) {
      // As far as expected, and no farther.
      const Pose2 odom_T_robot = state_.local_T_odom.inverse() * guess;
      state_.local_T_odom = local_T_robot * odom_T_robot.inverse();
    }
    state_.last_local_T_robot = local_T_robot;
    return state_.local_T_odom.inverse() * local_T_robot;
  }

  [[nodiscard]] const Pose2& local_T_odom() const { return state_.local_T_odom; }

  struct State {
    std::optional<Pose2> last_local_T_robot{};
    Pose2 local_T_odom{};

    template <typename Archive>
    void archive(Archive& a) {
      a(last_local_T_robot, local_T_odom);
    }
  };

  [[nodiscard]] const State& state() const { return state_; }
  /// Throws UsageError when its poses are no numbers.
  void restore(const State& state) {
    const auto finite = [](const Pose2& pose) { return pose.vector().allFinite(); };
    require_sound(finite(state.local_T_odom) && finite(state.last_local_T_robot.value_or(Pose2{})),
                  "a frame to drive by that is no pose");
    state_ = state;
  }

 private:
  [[nodiscard]] static double size_of(const Pose2& motion) {
    return hypotenuse(motion.x, motion.y) + kOdomFrame.lever_m * std::abs(wrap_angle(motion.yaw));
  }

  State state_{};
};

}  // namespace loopstone
