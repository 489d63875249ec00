#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// Where a sensor met a landmark, seen from the robot.
struct LandmarkObservation {
  /// Robot frame at the reading's stamp [m]; of a round landmark a place on its surface.
  Eigen::Vector2d point{0.0, 0.0};
  /// From the sensor to it, unit length, robot frame.
  Eigen::Vector2d direction{1.0, 0.0};
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of the point [m^2]
  std::optional<int> id{};  ///< which landmark; nothing: it looks like all the others
  /// How far beside the direction each beam met it [m]; empty: the point is its centre already.
  std::vector<double> beams_beside_m{};
  /// And how far beyond the point; as many.
  std::vector<double> beams_beyond_m{};
};

/// All that was seen at one moment.
struct LandmarkReading {
  Stamp stamp{};
  std::vector<LandmarkObservation> observations{};
};

/// The centre of a round landmark of that radius by what was seen of it, robot frame: from the
/// point on by the mean depth sqrt(r^2 - y^2) of the surface that beams beside by y met. The point
/// itself where there are no beams, and for a radius of 0.
[[nodiscard]] Eigen::Vector2d centre_of(const LandmarkObservation& observation, double radius_m);

/// A landmark seen at a range and a bearing.
/// \param bearing_rad    sensor frame, counter-clockwise from x
/// \param robot_T_sensor where the sensor sits
[[nodiscard]] LandmarkObservation observed(double range_m, double bearing_rad, double range_sigma_m,
                                           double bearing_sigma_rad,
                                           const Pose2& robot_T_sensor = {});

}  // namespace loopstone
