#pragma once

#include <deque>
#include <optional>

#include "loopstone/odometry/gyro_heading.hpp"
#include "loopstone/odometry/odometer.hpp"
#include "loopstone/odometry/odometry_reading.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// What the queue of scans decides by.
struct ScanQueueNumbers {
  int patience_ms = 250;
  int silent_start_ms = 1000;
  int silence_of_increments_ms = 2000;
  int short_silence_of_increments_ms = 250;
  double silence_steps = 4.0;
  int readings_to_know = 40;
  int silence_of_sums_ms = 60000;
  double shift_rate = 0.1;
  int most_shift_ms = 8000;
};
inline constexpr ScanQueueNumbers kScanQueue{};

template <typename Visitor>
void visit_numbers(const ScanQueueNumbers& n, Visitor&& visit) {
  visit(
      "patience_ms", n.patience_ms,
      "chosen: so long a scan waits for odometry of its time; buses and drivers are late by less");
  visit("silent_start_ms", n.silent_start_ms,
        "chosen: a stream that begins so long without odometry has none");
  visit("silence_of_increments_ms", n.silence_of_increments_ms,
        "chosen: counts since the last reading are lost with the readings between: after so long, "
        "too many, however rarely readings come");
  visit("short_silence_of_increments_ms", n.short_silence_of_increments_ms,
        "chosen: but not before: so late a single reading's stamp may be");
  visit("silence_steps", n.silence_steps,
        "chosen: nor before so many of the usual times between readings");
  visit("readings_to_know", n.readings_to_know,
        "chosen: so many tell what is usual; some seconds at ten a second");
  visit("silence_of_sums_ms", n.silence_of_sums_ms,
        "chosen: poses and counters go on, unless the robot was off, which takes longer");
  visit("shift_rate", n.shift_rate,
        "chosen: where odometry is read at another time from now on, motions are wrong by that "
        "share until it is");
  visit("most_shift_ms", n.most_shift_ms, "derived: less than the memory of odometry, 10 s");
}

/// Holds each scan back until odometry for its time has come, at most 0.25 s of the recording. A
/// stream that has had neither odometry nor gyro for its first second has none: then scans wait no
/// more, until some comes.
///
/// Clocks of laser and odometry may run apart: shift_odometry() says by how much.
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
  /// Dead reckoning at the stamp of the last scan: from wheels or the log's own poses; as long as
  /// there are none, the gyro's heading.
  [[nodiscard]] std::optional<OdometryReading> reading_at(Stamp stamp) const;

  /// Odometry's clock is so much ahead of the laser's, beyond what was known: step by step it is
  /// read so much later. False, and nothing is done, when both would be too far apart.
  bool shift_odometry(Duration later);
  /// Whether it is on its way there.
  [[nodiscard]] bool is_shifting() const { return own_.shift != own_.shift_wanted; }

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
  struct State {
    /// What the sensors' parts do not have.
    struct Own {
      std::deque<LaserScan> waiting{};
      std::optional<Stamp> first{};  ///< of any message
      Stamp newest{};
      bool finished = false;
      Travel travel{};
      bool increments = false;  ///< odometry is counts since the last reading
      Duration shift{};         ///< of odometry's clock from the laser's, at the last scan
      Duration shift_wanted{};
      std::optional<Stamp> last_scan{};

      template <typename Archive>
      void archive(Archive& a) {
        a(waiting, first, newest, finished, travel, increments, shift.nanoseconds,
          shift_wanted.nanoseconds, last_scan);
      }
    };
    Odometer::State odometer{};
    GyroHeading::State gyro{};
    Own own{};

    template <typename Archive>
    void archive(Archive& a) {
      a(odometer, gyro, own);
    }
  };

  [[nodiscard]] State state() const;
  /// Throws UsageError when nothing can have led to it; then the queue is of no use.
  void restore(State state);

 private:
  /// What odometry's newest pose adds to the path so far.
  void follow_odometry();
  [[nodiscard]] Duration longest_step() const;
  /// Of odometry's clock, for the next scan.
  [[nodiscard]] Duration shift_at(Stamp scan) const;

  bool counts_are_cumulative_;
  Odometer odometer_;
  GyroHeading gyro_{};
  State::Own own_{};
};

}  // namespace loopstone
