#pragma once

#include <Eigen/Core>

#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// What a motion's heading error is proportional to: the way [m], backwards negative, and the turn
/// [rad].
///
/// \param said    by odometry, without its scale
/// \param path_m  travelled by odometry meanwhile; what is longer than an arc between both ends is
///                taken to be driven forwards
[[nodiscard]] Eigen::Vector2d way_and_turn(const Pose2& said, double path_m);

/// Errors that odometry always makes: wheels of another size than was told, of unequal size, or
/// farther apart, a gyro whose scale is off. (Borenstein and Feng 1996: systematic errors.)
struct OdometryCorrection {
  double scale = 1.0;         ///< odometry's way / the real one
  double rad_per_m = 0.0;     ///< the robot turns so much more than odometry says, a metre of way
  double rad_per_turn = 0.0;  ///< and so much for each radian that odometry says

  /// The motion without them. What it turns more is spread evenly along the way.
  [[nodiscard]] Pose2 corrected(const Pose2& said, double path_m) const;
};

}  // namespace loopstone
