#include "loopstone/localization/motion_models.hpp"

#include <cmath>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {

TurnGoTurn turn_go_turn(const Pose2& from_T_to) {
  double first = std::atan2(from_T_to.y, from_T_to.x);
  double travel = hypotenuse(from_T_to.x, from_T_to.y);
  if (std::abs(first) > kPi / 2.0) {
    first = wrap_angle(first + kPi);
    travel = -travel;
  }
  return {first, travel, wrap_angle(from_T_to.yaw - first)};
}

Pose2 to_pose(const TurnGoTurn& motion) {
  return {motion.travel_m * std::cos(motion.first_turn_rad),
          motion.travel_m * std::sin(motion.first_turn_rad),
          wrap_angle(motion.first_turn_rad + motion.second_turn_rad)};
}

Pose2 sample_odometry_motion(const Pose2& map_T_from, const TurnGoTurn& motion,
                             const OdometryMotionNoise& noise, Rng& rng) {
  constexpr double kNoDirectionM = 0.01;
  const double travel = std::abs(motion.travel_m);
  const bool directed = travel >= kNoDirectionM;
  const double first_turn = directed ? std::abs(motion.first_turn_rad) : 0.0;
  const double second_turn =
      std::abs(directed ? motion.second_turn_rad
                        : wrap_angle(motion.first_turn_rad + motion.second_turn_rad));
  const auto turn_sigma = [&](double turn) {
    return hypotenuse(noise.turn_from_turn * turn, noise.turn_from_travel * travel);
  };
  const double travel_sigma = hypotenuse(noise.travel_from_travel * travel,
                                         noise.travel_from_turn * (first_turn + second_turn));
  TurnGoTurn sampled;
  sampled.first_turn_rad = rng.normal(motion.first_turn_rad, turn_sigma(first_turn));
  sampled.travel_m = rng.normal(motion.travel_m, travel_sigma);
  sampled.second_turn_rad = rng.normal(motion.second_turn_rad, turn_sigma(second_turn));
  return map_T_from * to_pose(sampled);
}

Pose2 sample_velocity_motion(const Pose2& map_T_from, double speed_m_s, double yaw_rate_rad_s,
                             double duration_s, const VelocityMotionNoise& noise, Rng& rng) {
  const auto sigma = [&](double from_speed, double from_rate) {
    return hypotenuse(from_speed * speed_m_s, from_rate * yaw_rate_rad_s);
  };
  const double speed = rng.normal(speed_m_s, sigma(noise.speed_from_speed, noise.speed_from_rate));
  const double rate =
      rng.normal(yaw_rate_rad_s, sigma(noise.rate_from_speed, noise.rate_from_rate));
  const double last_turn = rng.normal(0.0, sigma(noise.turn_from_speed, noise.turn_from_rate));
  const Pose2 arc = exp(Tangent2{speed * duration_s, 0.0, rate * duration_s});
  return map_T_from * arc * Pose2{0.0, 0.0, last_turn * duration_s};
}

GaussianMotion::GaussianMotion(const Pose2& from_T_to, const Eigen::Matrix3d& covariance)
    : from_T_to_(from_T_to), root_(square_root(covariance)) {}

Pose2 GaussianMotion::sample(const Pose2& map_T_from, Rng& rng) const {
  Eigen::Vector3d unit;
  for (int i = 0; i < 3; ++i) unit[i] = rng.normal();
  const Eigen::Vector3d sampled = from_T_to_.vector() + root_ * unit;
  return map_T_from * Pose2{sampled.x(), sampled.y(), wrap_angle(sampled.z())};
}

}  // namespace loopstone
