#pragma once

#include <Eigen/Core>

namespace loopstone {

/// Which planar motions a set of residuals observes: the information matrix of (x, y, yaw about a centre), with yaw in
/// units of a typical arm so that metres compare with metres, in its eigenbasis.
struct Observability {
  Eigen::Matrix3d directions;   ///< columns: unit motions, scaled coordinates
  Eigen::Vector3d information;  ///< of each, ascending [1/m^2 before the division by sigma^2]
  Eigen::Array<bool, 3, 1> observed;
  Eigen::Matrix3d
      to_scaled;  ///< from (x, y, yaw) of the pose to the scaled motion about the centre

  [[nodiscard]] bool complete() const { return observed.all(); }
  /// What is left of a motion (x, y, yaw) without its unobserved parts.
  [[nodiscard]] Eigen::Vector3d observed_part(const Eigen::Vector3d& motion) const;
  /// The step that the information and a gradient give, none along unobserved directions.
  [[nodiscard]] Eigen::Vector3d solve(const Eigen::Vector3d& gradient) const;
  /// sigma^2 times the inverse of the information, large along unobserved directions.
  [[nodiscard]] Eigen::Matrix3d covariance(double sigma) const;
};

/// \param information  of (x, y, yaw), where yaw turns about the origin of the source frame
/// \param centre       about which turns are judged, relative to that origin, target axes [m]
/// \param arm_m        typical distance of points from the centre, > 0
[[nodiscard]] Observability observability_of(const Eigen::Matrix3d& information,
                                             const Eigen::Vector2d& centre, double arm_m);

}  // namespace loopstone
