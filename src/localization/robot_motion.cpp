#include "localization/robot_motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "localization/pose_track.hpp"
#include "loopstone/localization/motion_models.hpp"

namespace loopstone {

namespace {

/// Without odometry the robot keeps its velocity, give or take.
constexpr double kUnknownSpeed = 0.4;    // [m/s]
constexpr double kUnknownYawRate = 0.8;  // [rad/s]
/// Dead reckoning's own covariance leaves out what is systematic.
constexpr double kOdometryFactor = 2.0;
/// Particles spread at least so much with each step, or few would stand for many.
constexpr double kJitterM = 0.01;
constexpr double kJitterRad = 0.005;
constexpr double kLeastSeconds = 1e-6;
/// Of the time from scan to scan, the newest one's share in the mean; and what less of it is not
/// believed: scans that came in a burst have stamps that are nearly the same.
constexpr double kNewest = 0.1;
constexpr double kLeastOfUsual = 0.5;
/// Standard deviation of what lost counts did not tell, by the fastest that the robot has been seen
/// to move.
constexpr double kUntold = 0.5;

/// No robot indoors is faster, nor turns faster [m/s, rad/s].
constexpr double kFastestM = 5.0;
constexpr double kFastestRad = 6.0;

/// The velocity at a scan is that of the time before it.
constexpr double kVelocityS = 0.05;

std::optional<Tangent2> velocity_at(Stamp stamp, const Odometer& odometer) {
  const auto motion = odometer.motion_between(stamp - Duration::from_seconds(kVelocityS), stamp);
  if (!motion) return {};
  return log(motion->pose) / kVelocityS;
}

}  // namespace

std::optional<PoseWithCovariance2> RobotMotion::told(Stamp from, Stamp stamp,
                                                     const Odometer& odometer) {
  auto motion = odometer.motion_between(from, stamp);
  if (!motion) return {};
  had_odometry_ = true;
  motion->covariance *= kOdometryFactor;
  const double untold_s = odometer.untold_s(from, stamp);
  is_told_ = !(untold_s > 0.0);
  if (is_told_) return motion;
  const double sigma_m = kUntold * fastest_m_s_ * untold_s;
  untold_m_ = sigma_m;
  const double sigma_rad = kUntold * fastest_rad_s_ * untold_s;
  motion->covariance.diagonal() +=
      Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad);
  return motion;
}

PoseWithCovariance2 RobotMotion::guessed(double duration_s,
                                         const std::optional<PoseWithCovariance2>& told,
                                         const Trust& trust) const {
  PoseWithCovariance2 motion{.pose = exp(Tangent2(velocity_ * duration_s))};
  const double sigma_m = kUnknownSpeed * duration_s;
  const double sigma_rad = kUnknownYawRate * duration_s;
  motion.covariance.diagonal() << sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad;
  if (told && trust.translation) {
    motion.pose.x = told->pose.x;
    motion.pose.y = told->pose.y;
    motion.covariance.topLeftCorner<2, 2>() = told->covariance.topLeftCorner<2, 2>();
  }
  if (told && trust.rotation) {
    motion.pose.yaw = told->pose.yaw;
    motion.covariance(2, 2) = told->covariance(2, 2);
  }
  return motion;
}

PoseWithCovariance2 RobotMotion::step_to(Stamp stamp, const Odometer& odometer,
                                         const Trust& trust) {
  untold_m_ = 0.0;
  is_told_ = false;
  velocity_change_ = Tangent2::Zero();
  const std::optional<Tangent2> velocity_before =
      std::exchange(velocity_at_scan_, velocity_at(stamp, odometer));
  if (velocity_before && velocity_at_scan_)
    velocity_change_ = *velocity_at_scan_ - *velocity_before;
  if (!first_stamp_) first_stamp_ = stamp;
  const Stamp from = last_stamp_.value_or(stamp);
  last_stamp_ = stamp;
  if (from == stamp) return {};
  const double duration_s = (stamp - from).seconds();
  const auto known = told(from, stamp, odometer);
  is_guessed_ = !known || !trust.translation || !trust.rotation;
  PoseWithCovariance2 motion;
  if (is_guessed_) {
    motion = guessed(duration_s, known, trust);
    is_told_ = false;
    untold_m_ = 0.0;
  } else {
    motion = *known;
    velocity_ = log(motion.pose) / std::max(duration_s, kLeastSeconds);
    if (is_told_) {
      fastest_m_s_ = std::max(fastest_m_s_, velocity_.head<2>().norm());
      fastest_rad_s_ = std::max(fastest_rad_s_, std::abs(velocity_.z()));
    }
  }
  const double way_m = motion.pose.translation().norm();
  travelled_m_ += way_m;
  travelled_since_weighing_m_ += way_m;
  turned_since_weighing_rad_ += std::abs(motion.pose.yaw);
  since_weighing_ = compound(since_weighing_, motion);
  since_weighing_s_ += duration_s;
  return motion;
}

void RobotMotion::found_at(const Pose2& map_T_robot) {
  if (is_guessed_ && found_ && *last_stamp_ > found_stamp_) {
    const double seconds = (*last_stamp_ - found_stamp_).seconds();
    usual_s_ = usual_s_ ? *usual_s_ + kNewest * (seconds - *usual_s_) : seconds;
    const Tangent2 velocity =
        log(found_->inverse() * map_T_robot) / std::max(seconds, kLeastOfUsual * *usual_s_);
    // A robot that was looked for and found elsewhere did not drive there.
    if (velocity.head<2>().norm() < kFastestM && std::abs(velocity.z()) < kFastestRad)
      velocity_ = velocity;
  }
  found_ = map_T_robot;
  found_stamp_ = *last_stamp_;
}

PoseBelief::MotionModel RobotMotion::sampler(
    const std::optional<PoseWithCovariance2>& track) const {
  const Pose2& motion = since_weighing_.pose;
  if (model_ == ParticleMotion::kOdometry) {
    return [parts = turn_go_turn(motion), noise = odometry_noise_](const Pose2& pose, Rng& rng) {
      return sample_odometry_motion(pose, parts, noise, rng);
    };
  }
  if (model_ == ParticleMotion::kVelocity) {
    const Tangent2 way = log(motion);
    const double duration_s = std::max(since_weighing_s_, kLeastSeconds);
    return [way, duration_s, noise = velocity_noise_](const Pose2& pose, Rng& rng) {
      return sample_velocity_motion(pose, way.x() / duration_s, way.z() / duration_s, duration_s,
                                    noise, rng);
    };
  }
  Eigen::Matrix3d covariance = since_weighing_.covariance;
  covariance.diagonal() +=
      Eigen::Vector3d(kJitterM * kJitterM, kJitterM * kJitterM, kJitterRad * kJitterRad);
  if (track) {
    // On the axes of the robot as it was when the particles were weighed last.
    const Eigen::Matrix2d then_R_map = (track->pose * motion.inverse()).rotation().transpose();
    const Eigen::Matrix2d position = track->covariance.topLeftCorner<2, 2>();
    covariance.topLeftCorner<2, 2>() +=
        scale_covariance(then_R_map * position * then_R_map.transpose(), motion.translation());
  }
  return [gaussian = GaussianMotion(motion, covariance)](const Pose2& pose, Rng& noise) {
    return gaussian.sample(pose, noise);
  };
}

void RobotMotion::particles_moved() {
  since_weighing_ = {};
  since_weighing_s_ = 0.0;
}

void RobotMotion::particles_weighed() {
  particles_moved();
  travelled_since_weighing_m_ = 0.0;
  turned_since_weighing_rad_ = 0.0;
}

}  // namespace loopstone
