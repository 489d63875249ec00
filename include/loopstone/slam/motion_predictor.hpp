#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/odometry/odometry_accuracy.hpp"
#include "loopstone/odometry/odometry_check.hpp"
#include "loopstone/odometry/odometry_reading.hpp"

namespace loopstone {

/// Where the robot may be, before the laser is asked.
struct MotionGuess {
  Pose2 local_T_robot{};
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of (x, y, yaw), local frame
  bool measured = false;  ///< the translation is odometry's, so it holds what the laser leaves open
};

/// The motion from one reading to another as odometry tells it, and how far to trust that.
struct ToldMotion {
  Pose2 motion{};
  double sigma_m = 0.0;
  double sigma_rad = 0.0;
};

/// Guesses the motion to the next scan: odometry's as long as it can be trusted, else the motion
/// goes on as it was.
///
/// How wrong a motion that goes on may be is learned from how wrong it was: a robot that turns on
/// the spot and a scanner with irregular stamps need wider windows than a steady drive.
class MotionPredictor {
 public:
  /// \param check  false: odometry is trusted whatever the laser says
  explicit MotionPredictor(bool check = true) : checks_(check) {}

  /// At least one guess, the likeliest first. More than one where odometry says what the motion so
  /// far makes unlikely, or where the stamps leave in doubt how far a motion goes on.
  [[nodiscard]] std::vector<MotionGuess> guesses(
      Stamp stamp, const std::optional<OdometryReading>& odometry) const;

  /// Without odometry: the motion goes on. Nothing when it is too long ago for that to mean much.
  [[nodiscard]] std::vector<MotionGuess> coast_guesses(Stamp stamp) const;

  /// What odometry says of the motion between two readings, with what is known of its scale.
  /// Nothing when it can't be trusted with the translation, or was silent in between.
  [[nodiscard]] std::optional<ToldMotion> told(const OdometryReading& from, Stamp from_stamp,
                                               const OdometryReading& to) const;

  /// What the laser can tell of a scan's pose.
  struct Seen {
    bool translation = false;
    bool rotation = false;

    template <typename Archive>
    void archive(Archive& a) {
      a(translation, rotation);
    }
  };
  /// The robot's pose at a scan, as it was settled.
  void settle(Stamp stamp, const Pose2& local_T_robot,
              const std::optional<OdometryReading>& odometry, Seen seen);

  /// Standard deviations of a motion that goes on [m], [rad].
  [[nodiscard]] double coast_sigma_m() const;
  [[nodiscard]] double coast_sigma_rad() const;
  [[nodiscard]] const OdometryCheck& check() const { return check_; }
  [[nodiscard]] const Pose2& last_pose() const { return last_pose_; }
  [[nodiscard]] const std::optional<Stamp>& last_stamp() const { return last_stamp_; }

  template <typename Archive>
  void archive(Archive& a) {
    a(check_, accuracy_, last_stamp_, last_pose_, last_odometry_, last_seen_, steps_,
      coast_variance_m2_, coast_variance_rad2_);
  }

 private:
  struct Step {
    double seconds = 0.0;
    Tangent2 motion = Tangent2::Zero();

    template <typename Archive>
    void archive(Archive& a) {
      a(seconds, motion);
    }
  };

  /// The motion goes on: as far as the last one, and as fast.
  [[nodiscard]] std::vector<Pose2> coasts(Stamp stamp) const;
  [[nodiscard]] bool coast_is_over(Stamp stamp) const;
  /// Odometry's motion between two readings at the scale that was learned.
  [[nodiscard]] Pose2 scaled_motion(const OdometryReading& from, const OdometryReading& to) const;

  bool checks_;
  OdometryCheck check_{};
  OdometryAccuracy accuracy_{};
  std::optional<Stamp> last_stamp_{};
  Pose2 last_pose_{};
  std::optional<OdometryReading> last_odometry_{};
  Seen last_seen_{};
  std::deque<Step> steps_{};  ///< the last few
  double coast_variance_m2_ = 0.01;
  double coast_variance_rad2_ = 0.0225;
};

}  // namespace loopstone
