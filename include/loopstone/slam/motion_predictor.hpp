#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/odometry/odometry_accuracy.hpp"
#include "loopstone/odometry/odometry_check.hpp"
#include "loopstone/odometry/odometry_correction.hpp"
#include "loopstone/odometry/odometry_reading.hpp"
#include "loopstone/slam/lift_watch.hpp"
#include "loopstone/slam/odometry_turns.hpp"

namespace loopstone {

/// What the motion to the next scan is predicted by.
struct MotionPredictorNumbers {
  double wheel_share = kOdometryAccuracy.first_share;
  double wheel_rest_m = 0.01;
  double wheel_rest_rad = 0.01;
  double steady_rest_rad = 0.003;
  double steady_rad = 0.005;
  double wheel_rad_per_m = kOdometryAccuracy.first_rad_per_m;
  double turn_share = 0.02;
  int steps = 3;
  double longest_coast_s = 1.0;
  double longest_coast_steps = 4.0;
  double longest_gone_on_s = 3.0;
  double walking_m_s = 1.0;
  double walking_rad_s = 1.0;
  double speed_window_s = 1.0;
  double moves_m = 0.1;
  double moves_rad = 0.1;
  int speed_windows = 10;
  double speed_margin = 1.2;
  double slowest_m_s = 0.3;
  double slowest_rad_s = 0.6;
  double same_m = 0.05;
  double same_rad = 0.03;
  double coast_least_m = 0.05;
  double coast_most_m = 0.3;
  double coast_least_rad = 0.05;
  double coast_most_rad = 0.4;
  double coast_memory = 30.0;
  double coast_first_m2 = 0.01;
  double coast_first_rad2 = 0.0225;
  double first_m = 1.0;
  double first_rad = 1.0;
  double unlikely = 3.0;
  double by_hand_rad = 0.003;
};
inline constexpr MotionPredictorNumbers kMotionPredictor{};

// Over 60 lines: a list, a number each.
template <typename Visitor>
void visit_numbers(const MotionPredictorNumbers& n, Visitor&& visit) {
  visit("wheel_share", n.wheel_share,
        "derived: share of the motion that may be wrong: first_share of the accuracy of odometry");
  visit("wheel_rest_m", n.wheel_rest_m, "chosen: uncertain even at rest: stamps, rounding");
  visit("wheel_rest_rad", n.wheel_rest_rad, "chosen: as wheel_rest_m, of a point a metre off");
  visit(
      "steady_rest_rad", n.steady_rest_rad,
      "chosen: wheel_rest_rad of a steady heading: three times what the laser is sure of at best");
  visit("steady_rad", n.steady_rad,
        "chosen: a heading is steady that is usually off by less after 4 m: gyros are off by "
        "0.001 to 0.004, wheels by 0.013 and more");
  visit("wheel_rad_per_m", n.wheel_rad_per_m,
        "derived: heading lost by driving straight: first_rad_per_m of the accuracy of odometry");
  visit("turn_share", n.turn_share,
        "chosen: of all turning, over a longer way: errors of turns to the left and to the right "
        "cancel in part");
  visit(
      "steps", n.steps,
      "chosen: a velocity is the mean over so many motions: one alone is noise, many are the past");
  visit("longest_coast_s", n.longest_coast_s,
        "chosen: after so long a velocity says nothing of what comes later");
  visit("longest_coast_steps", n.longest_coast_steps,
        "chosen: but not before so many of the usual times between scans");
  visit("longest_gone_on_s", n.longest_gone_on_s,
        "chosen: across a gap of which nothing is told a robot more likely drove on than stopped: "
        "so long");
  visit(
      "walking_m_s", n.walking_m_s,
      "chosen: where nothing tells how far the robot went: as fast as a person walks, either way");
  visit("walking_rad_s", n.walking_rad_s, "chosen: and turns as a person does");
  visit("speed_window_s", n.speed_window_s,
        "chosen: speeds are measured over so long: stamps that jitter say little of shorter times");
  visit("moves_m", n.moves_m, "chosen: in such a time a robot that went less far stood");
  visit("moves_rad", n.moves_rad, "chosen: and turned less");
  visit("speed_windows", n.speed_windows,
        "chosen: a robot that moved in so many of them has shown how fast it is");
  visit("speed_margin", n.speed_margin,
        "chosen: no robot is faster than it was by more than a fifth");
  visit("slowest_m_s", n.slowest_m_s, "chosen: every robot may become as fast as this");
  visit("slowest_rad_s", n.slowest_rad_s, "chosen: as slowest_m_s");
  visit("same_m", n.same_m,
        "chosen: half a cell of the grid that scans are aligned to: motions that differ by less "
        "start the same alignment");
  visit("same_rad", n.same_rad, "chosen: turns by less do so, too: half a cell at two metres");
  visit("coast_least_m", n.coast_least_m,
        "chosen: a motion that goes on is never less uncertain, however steady the drive was");
  visit("coast_most_m", n.coast_most_m,
        "chosen: nor more: a cell of the coarse grid, from farther off no alignment starts");
  visit("coast_least_rad", n.coast_least_rad, "chosen: as coast_least_m");
  visit("coast_most_rad", n.coast_most_rad, "chosen: as coast_most_m");
  visit("coast_memory", n.coast_memory,
        "chosen: scans over which the uncertainty is learned, some seconds");
  visit("coast_first_m2", n.coast_first_m2,
        "chosen: its variance before anything is learned: 10 cm");
  visit("coast_first_rad2", n.coast_first_rad2, "chosen: likewise: 0.15 rad");
  visit("first_m", n.first_m,
        "chosen: of the first scan, whose pose is where the map begins: wide");
  visit("first_rad", n.first_rad, "chosen: as first_m");
  visit("unlikely", n.unlikely,
        "chosen: odometry that is so many standard deviations from the motion so far is one of "
        "several guesses");
  visit(
      "by_hand_rad", n.by_hand_rad,
      "chosen: wheels that stand while a gyro has felt so much of a turn since say nothing of the "
      "way: more than a gyro's noise");
}

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

/// What odometry told from scan to scan since the laser placed the robot last.
struct UnseenMotion {
  Stamp from{};
  Pose2 motion{};         ///< until it fell silent for the first time
  double untold_s = 0.0;  ///< in which it was silent
  Pose2 after{};          ///< what it told since
  double told_m = 0.0;    ///< way that it told

  template <typename Archive>
  void archive(Archive& a) {
    a(from, motion, untold_s, after, told_m);
  }
};

/// A motion of which odometry told a part: before * any motion of some time * after.
struct PartlyToldMotion {
  Pose2 before{};
  double untold_s = 0.0;
  Pose2 after{};
  double told_m = 0.0;   ///< way
  double sigma_m = 0.0;  ///< of what was told
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
  /// \param scale  odometry's way / the real one, as another drive told it; 1: nothing is known
  explicit MotionPredictor(bool check = true, double scale = 1.0) : checks_(check) {
    if (scale != 1.0) check_.assume_scale(scale);
  }

  /// At least one guess, the likeliest first. More than one where odometry says what the motion so
  /// far makes unlikely, or where the stamps leave in doubt how far a motion goes on.
  [[nodiscard]] std::vector<MotionGuess> guesses(
      Stamp stamp, const std::optional<OdometryReading>& odometry) const;

  /// Without odometry: the motion goes on. Nothing when it is too long ago for that to mean much.
  [[nodiscard]] std::vector<MotionGuess> coast_guesses(Stamp stamp) const;

  /// What odometry says of the motion between two readings, without the errors that are known.
  /// Nothing when it can't be trusted with the translation, or was silent in between.
  [[nodiscard]] std::optional<ToldMotion> told(const OdometryReading& from, Stamp from_stamp,
                                               const OdometryReading& to) const;
  /// The same of a motion during which it was silent, from scan to scan; nothing, too, where scans
  /// were placed in between.
  /// \param from, from_stamp  of the last scan that the laser placed
  [[nodiscard]] std::optional<PartlyToldMotion> partly_told(const OdometryReading& from,
                                                            Stamp from_stamp,
                                                            const OdometryReading& to,
                                                            Stamp to_stamp) const;
  /// The robot's place at the newest scan is one to go on from, however it was found.
  void forget_unseen() { own_.unseen.reset(); }

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

  /// As fast as the robot may be by what it has shown [m/s], [rad/s]; before that, as a person is.
  [[nodiscard]] double fastest_m_s() const;
  [[nodiscard]] double fastest_back_m_s() const;
  [[nodiscard]] double fastest_rad_s() const;

  /// Odometry's heading hardly drifts and does not slip, as a gyro's.
  [[nodiscard]] bool heading_is_steady() const;

  /// Standard deviations of a motion that goes on [m], [rad].
  [[nodiscard]] double coast_sigma_m() const;
  [[nodiscard]] double coast_sigma_rad() const;
  [[nodiscard]] const OdometryCheck& check() const { return check_; }
  /// Whether somebody carries the robot, and since when.
  [[nodiscard]] const LiftWatch& lift() const { return lift_; }
  void forget_lag() { check_.forget_lag(); }
  [[nodiscard]] const Pose2& last_pose() const { return own_.last_pose; }
  [[nodiscard]] const std::optional<Stamp>& last_stamp() const { return own_.last_stamp; }

  /// From one scan to the next.
  struct Step {
    double seconds = 0.0;
    Tangent2 motion = Tangent2::Zero();

    template <typename Archive>
    void archive(Archive& a) {
      a(seconds, motion);
    }
  };
  /// How fast the robot was, where the laser held it.
  struct Speeds {
    double window_s = 0.0;  ///< of the window that is being measured
    double window_m = 0.0;
    double window_back_m = 0.0;
    double window_rad = 0.0;
    int windows = 0;  ///< in which it moved
    double top_m_s = 0.0;
    double top_back_m_s = 0.0;
    double top_rad_s = 0.0;

    template <typename Archive>
    void archive(Archive& a) {
      a(window_s, window_m, window_back_m, window_rad, windows, top_m_s, top_back_m_s, top_rad_s);
    }
  };

  struct State {
    /// What the parts do not have.
    struct Own {
      std::optional<Stamp> last_stamp{};
      Pose2 last_pose{};
      std::optional<OdometryReading> last_odometry{};
      Seen last_seen{};
      std::deque<Step> steps{};  ///< the last few
      double coast_variance_m2 = kMotionPredictor.coast_first_m2;
      double coast_variance_rad2 = kMotionPredictor.coast_first_rad2;
      Speeds speeds{};
      std::optional<UnseenMotion> unseen{};
      Stamp placed{};  ///< of the last scan that the laser placed, or the first one

      template <typename Archive>
      void archive(Archive& a) {
        a(last_stamp, last_pose, last_odometry, last_seen, steps, coast_variance_m2,
          coast_variance_rad2, unseen, placed, speeds);
      }
    };
    OdometryCheck::State check{};
    OdometryAccuracy::State accuracy{};
    OdometryTurns::State turns{};
    LiftWatch::State lift{};
    Own own{};

    template <typename Archive>
    void archive(Archive& a) {
      a(check, accuracy, turns, lift, own);
    }
  };

  [[nodiscard]] State state() const;
  /// Throws UsageError when nothing can have led to it; then the predictor is of no use.
  void restore(State state);

 private:
  /// The motion goes on: as far as the last one, and as fast.
  [[nodiscard]] std::vector<Pose2> coasts(Stamp stamp) const;
  [[nodiscard]] bool coast_is_over(Stamp stamp) const;
  void check_odometry(Stamp stamp, const Pose2& motion, const OdometryReading& odometry, Seen seen);
  void learn_coast(Stamp stamp, const Pose2& motion, Seen seen);
  void remember_step(Stamp stamp, const Pose2& motion);
  [[nodiscard]] bool knows_speeds() const;
  void measure_speed(double seconds, const Pose2& motion, Seen seen);
  [[nodiscard]] Pose2 gone_on(double seconds) const;
  [[nodiscard]] bool was_silent(const OdometryReading& odometry) const;
  /// Somebody carries the robot, as far as is known by this reading.
  [[nodiscard]] bool is_in_hands(const OdometryReading& odometry) const;
  [[nodiscard]] bool feels_hands(const OdometryReading& odometry) const;
  /// What is known of odometry's errors.
  [[nodiscard]] OdometryCorrection correction() const;
  /// Odometry's motion between two readings without them.
  [[nodiscard]] Pose2 corrected_motion(const OdometryReading& from,
                                       const OdometryReading& to) const;
  /// How far odometry may be wrong from scan to scan.
  [[nodiscard]] ToldMotion step_reach(const Pose2& said, const OdometryReading& to) const;
  void watch_lift(Stamp stamp, const Pose2& local_T_robot,
                  const std::optional<OdometryReading>& odometry, Seen seen);
  void learn_turns(const Pose2& motion, const OdometryReading& odometry, Seen seen);
  void follow_unseen(Stamp stamp, const Pose2& local_T_robot,
                     const std::optional<OdometryReading>& odometry, Seen seen);
  [[nodiscard]] bool may_tell(const OdometryReading& from, const OdometryReading& to) const;
  void go_on_unseen(Stamp stamp, const OdometryReading& odometry, UnseenMotion& unseen) const;
  [[nodiscard]] ToldMotion left_over(const Pose2& motion, const OdometryReading& from,
                                     const OdometryReading& to) const;

  bool checks_;
  OdometryCheck check_{};
  OdometryAccuracy accuracy_{};
  OdometryTurns turns_{};
  LiftWatch lift_{};
  State::Own own_{};
};

}  // namespace loopstone
