#pragma once

#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/registration/likelihood_field.hpp"

namespace loopstone {

/// What an error of odometry's scale adds to the covariance of a position on a way. Such an error
/// grows with the way, not with its root: over a way s by sigma * s. Where registration sees the
/// way the position stays sure and the growth is small; along a corridor the covariance remembers
/// how long the way has been.
[[nodiscard]] Eigen::Matrix2d scale_covariance(const Eigen::Matrix2d& position,
                                               const Eigen::Vector2d& way);

/// How far behind the measured ends of beams the walls of the map lie [m]. A map knows a face to a
/// cell: one drawn by a laser has it in the cell's middle, one drawn from a plan often at its near
/// edge; and lasers have offsets of their own. Half a cell matters when one wall alone says how far
/// along the robot is. Learned from what lets scans fit best.
class RangeOffset {
 public:
  [[nodiscard]] double metres() const { return metres_; }
  /// The points moved away from the laser by the offset and `more`.
  [[nodiscard]] std::vector<Eigen::Vector2d> applied(std::span<const Eigen::Vector2d> points_robot,
                                                     const Eigen::Vector2d& laser_robot,
                                                     double more = 0.0) const;
  /// Compares how well the scan fits with a little more of it and a little less, each at its own
  /// best pose, and takes a step to the better side. At most one cell.
  void learn(std::span<const Eigen::Vector2d> points_robot, const Eigen::Vector2d& laser_robot,
             const MapField& field, const Pose2& map_T_robot);

 private:
  double metres_ = 0.0;
  double slope_ = 0.0;      ///< of the cost of a point, mean of the last scans [1/m]
  double curvature_ = 0.0;  ///< likewise [1/m^2]
};

/// The best pose followed from scan to scan: dead reckoning between scans, registration to the map
/// at each of them, weighed by their covariances. Particles say which place the robot is in; this
/// says where in it, to a fraction of a cell.
/// Source: Thrun, Burgard and Fox 2005, table 3.3 (extended Kalman filter), with registration as
/// the measurement.
class PoseTrack {
 public:
  explicit PoseTrack(const PoseWithCovariance2& map_T_robot) : map_T_robot_(map_T_robot) {}

  void advance(const PoseWithCovariance2& motion);

  /// Registers a scan's returns (robot frame) to the walls and takes the result in unless it
  /// contradicts the prediction.
  /// \return whether it was taken in
  bool refine(std::span<const Eigen::Vector2d> points_robot, const Eigen::Vector2d& laser_robot,
              const MapField& field, RangeOffset& offset);

  [[nodiscard]] const PoseWithCovariance2& map_T_robot() const { return map_T_robot_; }
  /// Squared Mahalanobis distance of registrations from predictions, divided by 3, mean of the last
  /// ones: about 1 or less when all is well.
  [[nodiscard]] double innovation() const { return innovation_; }

 private:
  PoseWithCovariance2 map_T_robot_;
  double innovation_ = 1.0;
  int registered_ = 0;
  int refined_ = 0;
};

}  // namespace loopstone
