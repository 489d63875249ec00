#pragma once

#include <deque>
#include <optional>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/odometry/differential_drive.hpp"
#include "loopstone/odometry/gyro_bias.hpp"
#include "loopstone/odometry/odometry_options.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// What dead reckoning decides by.
struct OdometerNumbers {
  int memory_ms = 10000;
  int gyro_wait_ms = 100;
  int gyro_silence_ms = 500;
  int largest_gyro_gap_ms = 200;
  int gyro_hold_ms = 50;
  int standstill_ms = 500;
  int hands_ms = 100;
  int velocity_span_ms = 20;
  int counts_gap_ms = 300;
  double fastest_wheel_m_s = 20.0;
  double shortest_reset_s = 0.1;
  double enough_turning_rad2 = 0.05;
};
inline constexpr OdometerNumbers kOdometer{};

template <typename Visitor>
void visit_numbers(const OdometerNumbers& n, Visitor&& visit) {
  visit("memory_ms", n.memory_ms, "chosen: older poses are forgotten; no scan waits so long");
  visit("gyro_wait_ms", n.gyro_wait_ms,
        "chosen: so long a wheel reading waits for the gyro; both come ten times a second or more");
  visit("gyro_silence_ms", n.gyro_silence_ms,
        "chosen: a gyro that is silent for so long is not waited for");
  visit("largest_gyro_gap_ms", n.largest_gyro_gap_ms,
        "chosen: between samples that are interpolated; across a longer gap the wheels turn the "
        "robot");
  visit("gyro_hold_ms", n.gyro_hold_ms, "chosen: so long a rate is taken to stay the same");
  visit("standstill_ms", n.standstill_ms,
        "chosen: when the wheels have been still for so long the robot stands, and does not swing "
        "any more");
  visit("hands_ms", n.hands_ms,
        "chosen: wheels that have been still for so long stand: a robot that turns slowly counts "
        "more often");
  visit("velocity_span_ms", n.velocity_span_ms,
        "chosen: a velocity is taken over so long at least: readings may be a fraction of a "
        "millisecond apart");
  visit("counts_gap_ms", n.counts_gap_ms,
        "chosen: wheels report ten times a second or more; where they did not for so long, reports "
        "are lost");
  visit("fastest_wheel_m_s", n.fastest_wheel_m_s,
        "chosen: counters that jump by more were reset (the base was switched off and on), not "
        "driven");
  visit("shortest_reset_s", n.shortest_reset_s,
        "chosen: a shorter time between readings is taken for so long there: stamps are not that "
        "good");
  visit("enough_turning_rad2", n.enough_turning_rad2,
        "derived: of squared turns: a radian, told in intervals of a twentieth of one");
}

/// Dead reckoning while a log streams by: readings in, odom_T_robot at any recent stamp out.
///
///   Odometer odometer(robot.wheels);
///   odometer.add(ticks); odometer.add(imu); ...            // each sensor's readings in time order
///   if (const auto known = odometer.pose_at(scan.stamp)) use(known->pose, known->covariance);
///
/// Two sources of motion: wheel counts (with a gyro for the heading when there is one), or the
/// poses that the log's own dead reckoning reported. The kind that comes first is used to the end;
/// the other one is ignored.
///
/// Wheels and gyro: counts that a reading reports were made since the reading before it, at
/// constant speed. Within that time the heading follows the gyro, interpolated between its samples
/// (or, `alignment = nearest`, its sample nearest to the reading's stamp). A reading therefore
/// waits until the gyro has caught up, at most 0.1 s; where the gyro is silent the wheels turn the
/// robot. While all wheels have stood still for half a second the gyro's bias is learned and the
/// robot does not turn, unless the gyro says clearly that somebody turns it.
///
/// Memory is bounded: poses older than about 10 s are forgotten.
class Odometer {
 public:
  explicit Odometer(const WheelModel& wheels, const OdometryOptions& options = {});

  /// Readings that are not newer than the last of their kind, or not finite, are ignored.
  void add(const WheelTicks& ticks);
  void add(const ImuSample& sample);
  void add(const OdometryPose& pose);

  /// No more readings will come: those that still wait for the gyro are used as they are.
  void finish();

  /// odom_T_robot at a stamp and its covariance since the start (or since restart_at).
  ///  - between readings: along the arc;
  ///  - after the newest: at constant velocity, up to max_extrapolation_s, with a covariance that
  ///    grows accordingly;
  ///  - before the first reading: the first pose, up to max_extrapolation_s before it;
  ///  - otherwise (no odometry, too far ahead, forgotten): nothing.
  /// With `alignment = nearest`: the pose of the nearest reading, within max_extrapolation_s.
  [[nodiscard]] std::optional<PoseWithCovariance2> pose_at(Stamp stamp) const;

  /// from_T_to, and the covariance of that motion alone. Nothing when either end has no pose. from
  /// <= to.
  [[nodiscard]] std::optional<PoseWithCovariance2> motion_between(Stamp from, Stamp to) const;

  /// How long between the two [s] counts are missing that a reading makes since the one before it:
  /// what the wheels turned meanwhile is told by nobody. 0 for cumulative counters and for poses.
  [[nodiscard]] double untold_s(Stamp from, Stamp to) const;

  /// Until when the pose is known without extrapolation; nothing while there is no odometry.
  [[nodiscard]] std::optional<Stamp> newest() const;

  /// From this stamp on odom_T_robot is counted from this pose, with no uncertainty; all that
  /// depended on the old pose is forgotten. What is known about the sensors (the gyro's bias)
  /// stays.
  void restart_at(const Pose2& odom_T_robot, Stamp stamp);

  [[nodiscard]] double gyro_bias_rad_s() const { return bias_.bias_rad_s(); }
  /// Wheel readings whose heading came from the gyro, and from the wheels.
  [[nodiscard]] std::int64_t turned_by_gyro() const { return own_.turned_by_gyro; }
  [[nodiscard]] std::int64_t turned_by_wheels() const { return own_.turned_by_wheels; }
  /// How far the gyro felt the robot turn, either way, while all wheels stood [rad].
  [[nodiscard]] double turned_by_hand_rad() const { return own_.turned_by_hand_rad; }
  /// Correlation [-1, 1] of the turns that wheels (or the log's poses) and gyro tell, -1 when one
  /// of them has the wrong sign. Nothing before both turned by a radian or two.
  [[nodiscard]] std::optional<double> wheels_with_gyro() const;

  enum class Source { kNone, kWheels, kPoses };
  [[nodiscard]] Source source() const { return own_.source; }
  friend constexpr Source last_of(Source) { return Source::kPoses; }

  struct Node {
    Stamp stamp{};
    PoseWithCovariance2 odom_T_robot{};
    /// Of the motion from the node before, in that node's frame.
    Eigen::Matrix3d step_covariance = Eigen::Matrix3d::Zero();

    template <typename Archive>
    void archive(Archive& a) {
      a(stamp, odom_T_robot, step_covariance);
    }
  };
  struct Interval {  ///< between two wheel readings
    Stamp from{};
    Stamp to{};
    ArcMotion motion{};  ///< rotation as the wheels say
    bool still = false;

    template <typename Archive>
    void archive(Archive& a) {
      a(from, to, motion, still);
    }
  };
  struct Rate {
    Stamp stamp{};
    double rate_rad_s = 0.0;

    template <typename Archive>
    void archive(Archive& a) {
      a(stamp, rate_rad_s);
    }
  };
  /// Sums of products of the turns that wheels (w) and gyro (g) tell.
  struct Turns {
    double ww = 0.0;
    double wg = 0.0;
    double gg = 0.0;

    template <typename Archive>
    void archive(Archive& a) {
      a(ww, wg, gg);
    }
  };
  struct State {
    /// What the gyro's bias does not have.
    struct Own {
      Source source = Source::kNone;
      std::deque<Node> nodes{};  ///< stamps increase
      bool forgot_nodes = false;
      std::optional<WheelTicks> last_ticks{};
      std::deque<Interval> waiting{};
      std::deque<Rate> rates{};  ///< stamps increase
      std::optional<Stamp> started{};
      Stamp seen_until{};
      std::optional<Stamp> still_since{};
      std::int64_t turned_by_gyro = 0;
      std::int64_t turned_by_wheels = 0;
      double turned_by_hand_rad = 0.0;
      std::optional<OdometryPose> last_pose{};
      Pose2 odom_T_log_odom{};
      std::optional<Stamp> counted_from{};  ///< of the last restart
      Turns turns{};

      template <typename Archive>
      void archive(Archive& a) {
        a(source, nodes, forgot_nodes, last_ticks, waiting, rates, started, seen_until, still_since,
          turned_by_gyro, turned_by_wheels, turned_by_hand_rad, last_pose, odom_T_log_odom,
          counted_from, turns);
      }
    };
    Own own{};
    GyroBias::State bias{};

    template <typename Archive>
    void archive(Archive& a) {
      a(own, bias);
    }
  };

  [[nodiscard]] State state() const;
  /// Throws UsageError when nothing can have led to it; then the odometer is of no use.
  void restore(State state);

 private:
  void integrate_waiting(bool all);
  void integrate(Interval interval);
  void integrate_along_gyro(const Interval& interval);
  /// Poses that the log tells, by the gyro's turn meanwhile.
  void compare_with_gyro(const OdometryPose& from, const OdometryPose& to);
  void add_turns(double by_odometry, double by_gyro);
  void step(Stamp to, const ArcMotion& motion, bool yaw_from_gyro);
  void append(Stamp stamp, const Pose2& odom_T_robot, const Eigen::Matrix3d& step_covariance);
  void learn_bias(const Interval& interval);
  void forget_rates_before(Stamp stamp);
  [[nodiscard]] bool gyro_may_still_come(Stamp stamp) const;
  [[nodiscard]] bool gyro_covers(const Interval& interval) const;
  [[nodiscard]] const Rate* nearest_rate(Stamp stamp) const;
  [[nodiscard]] double rate_at(Stamp stamp) const;
  [[nodiscard]] PoseWithCovariance2 extrapolate(Stamp stamp) const;

  WheelModel wheels_;
  OdometryOptions options_;
  State::Own own_{};
  GyroBias bias_{};
};

}  // namespace loopstone
