#include "loopstone/odometry/differential_drive.hpp"

#include <cassert>
#include <cmath>

namespace loopstone {

std::int64_t count_difference(std::int64_t earlier, std::int64_t later, int bits) {
  assert(bits >= 1 && bits <= 62);
  // Unsigned arithmetic wraps by definition; signed would be undefined at the ends of the range.
  const std::uint64_t modulus = std::uint64_t{1} << bits;
  const std::uint64_t difference =
      (static_cast<std::uint64_t>(later) - static_cast<std::uint64_t>(earlier)) & (modulus - 1);
  const bool backwards = difference > modulus / 2;
  return backwards ? -static_cast<std::int64_t>(modulus - difference)
                   : static_cast<std::int64_t>(difference);
}

std::array<std::int64_t, 4> counts_between(const WheelTicks& earlier, const WheelTicks& later,
                                           const WheelModel& wheels) {
  if (!wheels.counts_are_cumulative) return later.counts;
  std::array<std::int64_t, 4> counts{};
  for (std::size_t i = 0; i < counts.size(); ++i) {
    counts[i] = count_difference(earlier.counts[i], later.counts[i], wheels.counter_bits);
  }
  return counts;
}

ArcMotion motion_of(const std::array<std::int64_t, 4>& counts, const WheelModel& wheels) {
  const auto metres = [&](std::size_t front, std::size_t rear) {
    return 0.5 * wheels.metres_per_count *
           (static_cast<double>(counts[front]) + static_cast<double>(counts[rear]));
  };
  const double right_m = metres(0, 2);
  const double left_m = metres(1, 3);
  return {0.5 * (left_m + right_m), (right_m - left_m) / wheels.track_width_m};
}

Pose2 integrate_arc(const ArcMotion& motion) {
  return exp(Tangent2{motion.distance_m, 0.0, motion.rotation_rad});
}

Pose2 integrate_euler(const ArcMotion& motion) {
  return {motion.distance_m, 0.0, wrap_angle(motion.rotation_rad)};
}

Eigen::Matrix3d motion_covariance(double distance_m, double rotation_rad, bool yaw_from_gyro,
                                  const OdometryOptions& options) {
  const double distance = std::abs(distance_m);
  const double turn = std::abs(rotation_rad);
  const double position = options.distance_noise * options.distance_noise * distance;
  const double heading =
      options.heading_noise_per_metre * options.heading_noise_per_metre * distance +
      options.heading_noise_per_radian * options.heading_noise_per_radian * turn;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  covariance(0, 0) = position;
  covariance(1, 1) = position;
  covariance(2, 2) = yaw_from_gyro ? kDifferentialDrive.gyro_share * heading : heading;
  return covariance;
}

}  // namespace loopstone
