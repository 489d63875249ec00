#pragma once

#include <Eigen/Core>
#include <cmath>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/geometry/pose3.hpp"

namespace loopstone {

/// Roll, pitch and yaw [rad] of a pose: the inverse of Pose3::from_roll_pitch_yaw. Pitch is in
/// [-pi/2, pi/2]; where it is +-pi/2 only roll and yaw together are determined, and both come out
/// of rounding.
[[nodiscard]] inline Eigen::Vector3d to_roll_pitch_yaw(const Pose3& pose) {
  const Eigen::Matrix3d r = pose.rotation.toRotationMatrix();
  return {std::atan2(r(2, 1), r(2, 2)), std::atan2(-r(2, 0), hypotenuse(r(0, 0), r(1, 0))),
          std::atan2(r(1, 0), r(0, 0))};
}

}  // namespace loopstone
