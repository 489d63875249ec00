#pragma once

#include <deque>
#include <optional>

#include "loopstone/odometry/gyro_heading.hpp"
#include "loopstone/odometry/odometer.hpp"
#include "loopstone/odometry/odometry_reading.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// Holds each scan back until odometry for its time has come, at most 0.25 s of the recording. A
/// stream that has had neither odometry nor gyro for its first second has none: then scans wait no
/// more, until some comes.
///
///   queue.add(message);
///   while (auto scan = queue.next()) use(*scan, queue.odometer().pose_at(scan->stamp));
class ScanQueue {
 public:
  explicit ScanQueue(const WheelModel& wheels)
      : counts_are_cumulative_(wheels.counts_are_cumulative), odometer_(wheels) {}

  /// Messages come in time order.
  void add(const SensorMessage& message);
  /// No more messages will come: the scans that still wait are ready as they are.
  void finish();

  /// The oldest scan, once it is ready.
  [[nodiscard]] std::optional<LaserScan> next();

  [[nodiscard]] const Odometer& odometer() const { return odometer_; }
  /// Dead reckoning at a scan's stamp: from wheels or the log's own poses; as long as there are
  /// none, the gyro's heading.
  [[nodiscard]] std::optional<OdometryReading> reading_at(Stamp stamp) const;

  template <typename Archive>
  void archive(Archive& a) {
    a(odometer_, gyro_, waiting_, first_, newest_, finished_, travel_, increments_);
  }

 private:
  /// What odometry's newest pose adds to the path so far.
  void follow_odometry();

  /// The path as odometry has it, up to its newest pose.
  struct Travel {
    std::optional<Stamp> stamp{};
    Pose2 odom_T_robot{};
    double path_m = 0.0;
    double turned_rad = 0.0;
    std::optional<Stamp> silent_until{};

    template <typename Archive>
    void archive(Archive& a) {
      a(stamp, odom_T_robot, path_m, turned_rad, silent_until);
    }
  };

  bool counts_are_cumulative_;
  bool increments_ = false;  ///< odometry is counts since the last reading
  Odometer odometer_;
  GyroHeading gyro_{};
  std::deque<LaserScan> waiting_{};
  std::optional<Stamp> first_{};  ///< of any message
  Stamp newest_{};
  bool finished_ = false;
  Travel travel_{};
};

}  // namespace loopstone
