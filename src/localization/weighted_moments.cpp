#include "loopstone/localization/weighted_moments.hpp"

#include <cmath>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {

PoseWithCovariance2 weighted_moments(std::span<const Pose2> poses,
                                     std::span<const double> weights) {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  Eigen::Vector2d heading = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    middle += weights[i] * poses[i].translation();
    heading += weights[i] * Eigen::Vector2d(std::cos(poses[i].yaw), std::sin(poses[i].yaw));
  }
  PoseWithCovariance2 moments;
  moments.pose = {middle.x(), middle.y(), std::atan2(heading.y(), heading.x())};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector3d off{poses[i].x - middle.x(), poses[i].y - middle.y(),
                              wrap_angle(poses[i].yaw - moments.pose.yaw)};
    moments.covariance.noalias() += weights[i] * off * off.transpose();
  }
  return moments;
}

}  // namespace loopstone
