#pragma once

#include <span>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/registration/likelihood_field.hpp"

namespace loopstone {

/// The best pose followed from scan to scan: dead reckoning between scans, registration to the map at each of them, weighed by
/// their covariances. Particles say which place the robot is in; this says where in it, to a fraction of a cell.
/// Source: Thrun, Burgard and Fox 2005, table 3.3 (extended Kalman filter), with registration as the measurement.
class PoseTrack {
 public:
  explicit PoseTrack(const PoseWithCovariance2& map_T_robot) : map_T_robot_(map_T_robot) {}

  void advance(const PoseWithCovariance2& motion);

  /// Registers a scan's returns (robot frame) to the walls and takes the result in unless it contradicts the prediction.
  /// \return whether it was taken in
  bool refine(std::span<const Eigen::Vector2d> points_robot, const MapField& field);

  [[nodiscard]] const PoseWithCovariance2& map_T_robot() const { return map_T_robot_; }
  /// Squared Mahalanobis distance of registrations from predictions, divided by 3, mean of the last ones: about 1 or less when
  /// all is well.
  [[nodiscard]] double innovation() const { return innovation_; }

 private:
  PoseWithCovariance2 map_T_robot_;
  double innovation_ = 1.0;
};

}  // namespace loopstone
