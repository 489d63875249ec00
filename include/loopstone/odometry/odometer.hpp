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

  /// Until when the pose is known without extrapolation; nothing while there is no odometry.
  [[nodiscard]] std::optional<Stamp> newest() const;

  /// From this stamp on odom_T_robot is counted from this pose, with no uncertainty; all that
  /// depended on the old pose is forgotten. What is known about the sensors (the gyro's bias)
  /// stays.
  void restart_at(const Pose2& odom_T_robot, Stamp stamp);

  [[nodiscard]] double gyro_bias_rad_s() const { return bias_.bias_rad_s(); }
  /// Wheel readings whose heading came from the gyro, and from the wheels.
  [[nodiscard]] std::int64_t turned_by_gyro() const { return turned_by_gyro_; }
  [[nodiscard]] std::int64_t turned_by_wheels() const { return turned_by_wheels_; }
  /// Correlation [-1, 1] of the turns that wheels and gyro tell, -1 when one of them has the wrong
  /// sign. Nothing before both turned by a radian or two.
  [[nodiscard]] std::optional<double> wheels_with_gyro() const;

  template <typename Archive>
  void archive(Archive& a) {
    a(source_, nodes_, forgot_nodes_, last_ticks_, waiting_, rates_, bias_, started_, seen_until_,
      still_since_, turned_by_gyro_, turned_by_wheels_, last_pose_, odom_T_log_odom_, counted_from_,
      turns_);
    a.check(waiting_.empty() || (started_ && !nodes_.empty()), "readings that wait for no start");
    a.check(source_ >= Source::kNone && source_ <= Source::kPoses, "odometry of no known kind");
    a.check(source_ == Source::kNone || !nodes_.empty(), "odometry that has not begun");
  }

 private:
  enum class Source { kNone, kWheels, kPoses };

  struct Node {
    Stamp stamp;
    PoseWithCovariance2 odom_T_robot;
    Eigen::Matrix3d step_covariance;  ///< of the motion from the node before, in that node's frame

    template <typename Archive>
    void archive(Archive& a) {
      a(stamp, odom_T_robot, step_covariance);
    }
  };
  struct Interval {  ///< between two wheel readings
    Stamp from;
    Stamp to;
    ArcMotion motion;  ///< rotation as the wheels say
    bool still = false;

    template <typename Archive>
    void archive(Archive& a) {
      a(from, to, motion, still);
    }
  };
  struct Rate {
    Stamp stamp;
    double rate_rad_s;

    template <typename Archive>
    void archive(Archive& a) {
      a(stamp, rate_rad_s);
    }
  };

  void integrate_waiting(bool all);
  void integrate(Interval interval);
  void integrate_along_gyro(const Interval& interval);
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
  Source source_ = Source::kNone;
  std::deque<Node> nodes_{};
  bool forgot_nodes_ = false;

  std::optional<WheelTicks> last_ticks_{};
  std::deque<Interval> waiting_{};
  std::deque<Rate> rates_{};
  GyroBias bias_{};
  std::optional<Stamp> started_{};
  Stamp seen_until_{};
  std::optional<Stamp> still_since_{};
  std::int64_t turned_by_gyro_ = 0;
  std::int64_t turned_by_wheels_ = 0;

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
  Turns turns_{};

  std::optional<OdometryPose> last_pose_{};
  Pose2 odom_T_log_odom_{};
  std::optional<Stamp> counted_from_{};  ///< of the last restart
};

}  // namespace loopstone
