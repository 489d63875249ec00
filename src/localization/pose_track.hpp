#pragma once

#include <optional>
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

/// What the error of a guessed velocity adds to the covariance of a position in a step, beside that
/// of the step itself: it lasts, so where registration does not see the way it grows with the time,
/// not with its root. Where it does, the position stays sure, and this is small.
/// \param step_sigma_m  of the step, along each axis
[[nodiscard]] Eigen::Matrix2d lasting_covariance(const Eigen::Matrix2d& position,
                                                 double step_sigma_m);

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

/// What odometry tells of a step from scan to scan.
struct OdometryStep {
  PoseWithCovariance2 motion{};
  /// From the velocity at the scan before to that at this one [m/s, m/s, rad/s], robot frame.
  Tangent2 velocity_change = Tangent2::Zero();
};

/// What a robot's odometry is wrong by all the time: wheels smaller than they are said to be, a
/// gyro with a scale of its own, a robot that draws to one side, stamps that are late. Learned from
/// where scans fit.
struct OdometryErrors {
  /// The way is longer by this share, turns are by this share, it turns so much on the way, and it
  /// is told of so much later than scans are [1, 1, rad/m, s].
  Eigen::Vector4d mean = Eigen::Vector4d::Zero();
  Eigen::Matrix4d covariance =
      Eigen::Vector4d(0.02 * 0.02, 0.02 * 0.02, 0.01 * 0.01, 0.05 * 0.05).asDiagonal();

  /// Of a short motion.
  [[nodiscard]] Pose2 corrected(const Pose2& motion,
                                const Tangent2& velocity_change = Tangent2::Zero()) const;
};

/// Errors of the map that scans taken one after the other have in common: no number of them makes
/// the pose surer than the walls are. The mean of what the last registrations were uncertain by.
class SharedError {
 public:
  void add(const Eigen::Matrix3d& covariance);
  [[nodiscard]] Eigen::Matrix3d covariance() const {
    return mean_.value_or(Eigen::Matrix3d::Zero());
  }

 private:
  std::optional<Eigen::Matrix3d> mean_{};
};

/// The best pose followed from scan to scan: dead reckoning between scans, registration to the map
/// at each of them, weighed by their covariances. Particles say which place the robot is in; this
/// says where in it, to a fraction of a cell.
/// Source: Thrun, Burgard and Fox 2005, table 3.3 (extended Kalman filter), with registration as
/// the measurement.
class PoseTrack {
 public:
  explicit PoseTrack(const PoseWithCovariance2& map_T_robot, const OdometryErrors& errors = {});

  /// By odometry, whose errors are learned.
  void advance(const OdometryStep& told);
  /// By a guess.
  void advance(const PoseWithCovariance2& motion);

  /// Registers a scan's returns (robot frame) to the walls and takes the result in unless it
  /// contradicts the prediction.
  /// \return whether it was taken in
  bool refine(std::span<const Eigen::Vector2d> points_robot, const Eigen::Vector2d& laser_robot,
              const MapField& field, RangeOffset& offset);

  [[nodiscard]] PoseWithCovariance2 map_T_robot() const {
    return {map_T_robot_, covariance_.topLeftCorner<3, 3>()};
  }
  [[nodiscard]] OdometryErrors errors() const {
    return {errors_, covariance_.bottomRightCorner<4, 4>()};
  }
  /// The same with what the registrations of the last scans have in common.
  [[nodiscard]] Eigen::Matrix3d covariance() const {
    return map_T_robot().covariance + shared_.covariance();
  }
  /// Squared Mahalanobis distance of registrations from predictions, divided by 3, mean of the last
  /// ones: about 1 or less when all is well.
  [[nodiscard]] double innovation() const { return innovation_; }

 private:
  using Matrix7 = Eigen::Matrix<double, 7, 7>;

  void advance(const Pose2& step, const Matrix7& change, const Matrix7& noise);

  Pose2 map_T_robot_;
  Eigen::Vector4d errors_;  ///< of odometry
  Matrix7 covariance_;      ///< of pose and errors
  SharedError shared_{};
  double innovation_ = 1.0;
  int registered_ = 0;
  int refined_ = 0;
};

}  // namespace loopstone
