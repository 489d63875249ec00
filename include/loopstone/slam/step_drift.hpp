#pragma once

#include <Eigen/Core>

namespace loopstone {

/// How far a path may drift from one node to the next.
struct StepDrift {
  /// (x, y, yaw), axes of the robot at the latter. They add up along the path, which the noise of
  /// matches in the graph's edges does not.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  bool open = false;    ///< the laser left a direction to odometry
  bool broken = false;  ///< the laser did not hold it at all
  /// Of the motion from what odometry says of it, the same axes; 0 where that is not known.
  Eigen::Vector2d off = Eigen::Vector2d::Zero();
};

}  // namespace loopstone
