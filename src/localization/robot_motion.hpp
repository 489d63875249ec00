#pragma once

#include <optional>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/localization_options.hpp"
#include "loopstone/localization/pose_belief.hpp"
#include "loopstone/odometry/odometer.hpp"

namespace loopstone {

/// How the robot has moved: from scan to scan, and since its particles were weighed last.
class RobotMotion {
 public:
  explicit RobotMotion(const LocalizationOptions& options)
      : model_(options.motion),
        odometry_noise_(options.odometry_noise),
        velocity_noise_(options.velocity_noise) {}

  /// Which parts of odometry tell how the robot moves.
  struct Trust {
    bool translation = true;
    bool rotation = true;
  };

  /// Goes on to the next scan's stamp. Returns the motion since the last one, from_T_to: by
  /// odometry, or at the last velocity, give or take, where there is none that is trusted.
  PoseWithCovariance2 step_to(Stamp stamp, const Odometer& odometer, const Trust& trust);
  /// All of it is trusted.
  PoseWithCovariance2 step_to(Stamp stamp, const Odometer& odometer) {
    return step_to(stamp, odometer, Trust{});
  }
  /// Where the robot was found to be at the last stamp: the only source of its velocity without
  /// odometry.
  void found_at(const Pose2& map_T_robot);
  /// Where it is found next says nothing of how it moved.
  void carried() { found_.reset(); }

  [[nodiscard]] const PoseWithCovariance2& since_weighing() const { return since_weighing_; }
  [[nodiscard]] bool moved(double distance_m, double angle_rad) const {
    return travelled_since_weighing_m_ >= distance_m || turned_since_weighing_rad_ >= angle_rad;
  }
  /// How particles move to now, drawn from the motion model.
  /// \param track  the robot's pose now: tells how uncertain its way along an unobserved direction
  ///               has become
  [[nodiscard]] PoseBelief::MotionModel sampler(
      const std::optional<PoseWithCovariance2>& track) const;
  /// The particles stand where the robot is now.
  void particles_moved();
  void particles_weighed();

  [[nodiscard]] const std::optional<Stamp>& first_stamp() const { return first_stamp_; }
  [[nodiscard]] const std::optional<Stamp>& last_stamp() const { return last_stamp_; }
  [[nodiscard]] const Tangent2& velocity() const {
    return velocity_;
  }  ///< robot frame [m/s, m/s, rad/s]
  [[nodiscard]] double travelled_m() const { return travelled_m_; }
  /// Of the last step, where odometry told of the one before as well; else none.
  [[nodiscard]] const Tangent2& velocity_change() const { return velocity_change_; }
  /// What odometry may have missed of the last step, one standard deviation [m].
  [[nodiscard]] double untold_m() const { return untold_m_; }
  /// The last step is odometry's, and it missed nothing.
  [[nodiscard]] bool is_told() const { return is_told_; }
  [[nodiscard]] bool had_odometry() const { return had_odometry_; }

 private:
  /// By odometry where it tells of the time from the last stamp to this one.
  [[nodiscard]] std::optional<PoseWithCovariance2> told(Stamp from, Stamp stamp,
                                                        const Odometer& odometer);
  /// At the last velocity; by odometry what of it is trusted.
  [[nodiscard]] PoseWithCovariance2 guessed(double duration_s,
                                            const std::optional<PoseWithCovariance2>& told,
                                            const Trust& trust) const;

  ParticleMotion model_;
  OdometryMotionNoise odometry_noise_;
  VelocityMotionNoise velocity_noise_;
  std::optional<Stamp> first_stamp_{};
  std::optional<Stamp> last_stamp_{};
  Tangent2 velocity_ = Tangent2::Zero();
  std::optional<Tangent2> velocity_at_scan_{};  ///< by odometry
  Tangent2 velocity_change_ = Tangent2::Zero();
  double untold_m_ = 0.0;
  double fastest_m_s_ = 0.0;  ///< that odometry has told of
  double fastest_rad_s_ = 0.0;
  bool is_told_ = false;
  bool had_odometry_ = false;
  bool is_guessed_ = true;  ///< the last step
  double travelled_m_ = 0.0;
  PoseWithCovariance2 since_weighing_{};
  double since_weighing_s_ = 0.0;
  double travelled_since_weighing_m_ = 0.0;
  double turned_since_weighing_rad_ = 0.0;
  std::optional<Pose2> found_{};
  Stamp found_stamp_{};
  std::optional<double> usual_s_{};  ///< from scan to scan, where there is no odometry
};

}  // namespace loopstone
