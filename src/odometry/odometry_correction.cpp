#include "loopstone/odometry/odometry_correction.hpp"

#include <algorithm>

namespace loopstone {

Eigen::Vector2d way_and_turn(const Pose2& said, double path_m) {
  const Tangent2 arc = log(said);
  return {arc.x() + std::max(0.0, path_m - arc.head<2>().norm()), said.yaw};
}

Pose2 OdometryCorrection::corrected(const Pose2& said, double path_m) const {
  Pose2 motion{said.x / scale, said.y / scale, said.yaw};
  if (rad_per_m == 0.0 && rad_per_turn == 0.0) return motion;
  Tangent2 twist = log(motion);
  twist.z() += Eigen::Vector2d(rad_per_m, rad_per_turn).dot(way_and_turn(said, path_m));
  return exp(twist);
}

}  // namespace loopstone
