#include "loopstone/sensor/landmark_reading.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {

Eigen::Vector2d centre_of(const LandmarkObservation& observation, double radius_m) {
  if (radius_m <= 0.0 || observation.beams_beside_m.empty()) return observation.point;
  double depth_m = 0.0;
  for (const double beside : observation.beams_beside_m) {
    depth_m += std::sqrt(std::max(0.0, radius_m * radius_m - beside * beside));
  }
  depth_m /= static_cast<double>(observation.beams_beside_m.size());
  return observation.point + depth_m * observation.direction;
}

// Polar to Cartesian to first order: the range's spread along the direction, range times the
// bearing's across it.
LandmarkObservation observed(double range_m, double bearing_rad, double range_sigma_m,
                             double bearing_sigma_rad, const Pose2& robot_T_sensor) {
  const Pose2 turn{0.0, 0.0, robot_T_sensor.yaw + bearing_rad};
  const double across_m = range_m * bearing_sigma_rad;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  covariance.diagonal() << range_sigma_m * range_sigma_m, across_m * across_m;
  const Eigen::Matrix2d rotation = turn.rotation();
  const Eigen::Vector2d direction = rotation.col(0);
  return {.point = robot_T_sensor.translation() + range_m * direction,
          .direction = direction,
          .covariance = rotation * covariance * rotation.transpose()};
}

}  // namespace loopstone
