#pragma once

#include <Eigen/Core>

#include "loopstone/base/options.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// How much a robot's motion strays from what odometry says. Thrun, Burgard and Fox 2005, section
/// 5.4.
struct OdometryMotionNoise {
  double turn_from_turn = 0.1;
  double turn_from_travel = 0.05;
  double travel_from_travel = 0.05;
  double travel_from_turn = 0.02;
};

template <typename Visitor>
void visit_options(OdometryMotionNoise& noise, Visitor&& visit) {
  visit("turn_from_turn", noise.turn_from_turn, Range{0.0, 10.0},
        "standard deviation of a turn by its size, alpha1 [rad/rad]");
  visit("turn_from_travel", noise.turn_from_travel, Range{0.0, 10.0},
        "and by the travel, alpha2 [rad/m]");
  visit("travel_from_travel", noise.travel_from_travel, Range{0.0, 10.0},
        "standard deviation of the travel by its length, alpha3 [m/m]");
  visit("travel_from_turn", noise.travel_from_turn, Range{0.0, 10.0},
        "and by the turns, alpha4 [m/rad]");
}

/// A motion between two odometry poses as a turn, a straight way and another turn.
struct TurnGoTurn {
  double first_turn_rad = 0.0;
  double travel_m = 0.0;
  double second_turn_rad = 0.0;
};

/// A robot that drives backwards travels a negative way: it does not turn round and back.
[[nodiscard]] TurnGoTurn turn_go_turn(const Pose2& from_T_to);
/// from_T_to again, exactly.
[[nodiscard]] Pose2 to_pose(const TurnGoTurn& motion);

/// Where the robot may be after odometry reported a motion: one sample.
/// Below a centimetre of travel its direction is noise: then the robot turned once, by the sum of
/// both turns.
/// Source: Thrun, Burgard and Fox 2005, table 5.6, with standard deviations that grow with the
/// motion.
[[nodiscard]] Pose2 sample_odometry_motion(const Pose2& map_T_from, const TurnGoTurn& motion,
                                           const OdometryMotionNoise& noise, Rng& rng);

/// How much a robot's motion strays from its commanded or measured velocity: standard deviations of
/// the speeds, section 5.3.
struct VelocityMotionNoise {
  double speed_from_speed = 0.05;
  double speed_from_rate = 0.02;
  double rate_from_speed = 0.05;
  double rate_from_rate = 0.1;
  double turn_from_speed = 0.02;
  double turn_from_rate = 0.02;
};

template <typename Visitor>
void visit_options(VelocityMotionNoise& noise, Visitor&& visit) {
  visit("speed_from_speed", noise.speed_from_speed, Range{0.0, 10.0},
        "standard deviation of the speed by its size, alpha1 [1]");
  visit("speed_from_rate", noise.speed_from_rate, Range{0.0, 10.0},
        "and by the yaw rate, alpha2 [m/rad]");
  visit("rate_from_speed", noise.rate_from_speed, Range{0.0, 10.0},
        "standard deviation of the yaw rate by the speed, alpha3 [rad/m]");
  visit("rate_from_rate", noise.rate_from_rate, Range{0.0, 10.0}, "and by its size, alpha4 [1]");
  visit("turn_from_speed", noise.turn_from_speed, Range{0.0, 10.0},
        "standard deviation of the extra turn at the end by the speed, alpha5 [rad/m]");
  visit("turn_from_rate", noise.turn_from_rate, Range{0.0, 10.0},
        "and by the yaw rate, alpha6 [1]");
}

/// One sample of where the robot may be after moving at a speed [m/s] and yaw rate [rad/s] for a
/// time: an arc and a last turn.
/// Source: Thrun, Burgard and Fox 2005, table 5.3; exact on straights too.
[[nodiscard]] Pose2 sample_velocity_motion(const Pose2& map_T_from, double speed_m_s,
                                           double yaw_rate_rad_s, double duration_s,
                                           const VelocityMotionNoise& noise, Rng& rng);

/// A motion whose covariance is known, as dead reckoning from wheels and a gyro gives it.
class GaussianMotion {
 public:
  /// \param from_T_to   the mean
  /// \param covariance  of (x, y, yaw) of from_T_to, on from's axes; positive semidefinite
  GaussianMotion(const Pose2& from_T_to, const Eigen::Matrix3d& covariance);

  [[nodiscard]] Pose2 sample(const Pose2& map_T_from, Rng& rng) const;

 private:
  Pose2 from_T_to_;
  Eigen::Matrix3d root_;  ///< root * root^T = covariance
};

}  // namespace loopstone
