#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/odometry/odometry_options.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// What the covariance of a step is computed by.
struct DifferentialDriveNumbers {
  double gyro_share = 0.01;
};
inline constexpr DifferentialDriveNumbers kDifferentialDrive{};

template <typename Visitor>
void visit_numbers(const DifferentialDriveNumbers& n, Visitor&& visit) {
  visit("gyro_share", n.gyro_share,
        "chosen: share of the heading's variance that is left with a gyro: it is ten times as good "
        "as wheels");
}

/// A motion of the robot along one arc.
struct ArcMotion {
  double distance_m = 0.0;    ///< of the robot's centre, forward
  double rotation_rad = 0.0;  ///< counter-clockwise

  template <typename Archive>
  void archive(Archive& a) {
    a(distance_m, rotation_rad);
  }
};

/// What one cumulative counter of `bits` bits moved by from one reading to the next: the difference
/// modulo 2^bits that is nearest to zero, so a wrap in either direction is seen through as long as
/// less than half of the range was missed. bits in [1, 62].
[[nodiscard]] std::int64_t count_difference(std::int64_t earlier, std::int64_t later, int bits);

/// Counts of all four wheels between two readings, whether the counters are cumulative or not.
[[nodiscard]] std::array<std::int64_t, 4> counts_between(const WheelTicks& earlier,
                                                         const WheelTicks& later,
                                                         const WheelModel& wheels);

/// The motion that counts [FR, FL, RR, RL] of a differential drive stand for:
///   left = (FL + RL) / 2, right = (FR + RR) / 2 in metres, distance = (left + right) / 2, rotation
///   = (right - left) / track.
/// Source: Siegwart and Nourbakhsh 2004, section 5.2.4.
[[nodiscard]] ArcMotion motion_of(const std::array<std::int64_t, 4>& counts,
                                  const WheelModel& wheels);

/// start_T_end of a motion at constant forward and turning speed: exactly the arc of a circle.
[[nodiscard]] Pose2 integrate_arc(const ArcMotion& motion);

/// The same by one Euler step: all of the distance along the old heading, then the turn. It errs by
/// distance * rotation / 2 sideways in each step; here to compare with what others publish.
[[nodiscard]] Pose2 integrate_euler(const ArcMotion& motion);

/// Covariance of one step in the frame of its start, (x, y, yaw).
///
/// Variances grow in proportion to distance and turn, so the uncertainty of a path does not depend
/// on how many readings it is cut into. (Thrun, Burgard and Fox 2005, table 5.6, let standard
/// deviations grow in proportion instead, which makes a fast encoder look better than a slow one.)
/// The factors are the options' standard deviations, squared.
/// \param yaw_from_gyro  the heading's factors count a hundredth (a tenth in standard deviation)
[[nodiscard]] Eigen::Matrix3d motion_covariance(double distance_m, double rotation_rad,
                                                bool yaw_from_gyro, const OdometryOptions& options);

}  // namespace loopstone
