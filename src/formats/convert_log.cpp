#include "loopstone/formats/convert_log.hpp"

#include <deque>
#include <optional>

#include "loopstone/formats/log_summary.hpp"
#include "loopstone/odometry/odometer.hpp"

namespace loopstone {
namespace {

/// Turns wheel counts and gyro into a pose at every wheel reading and scan. Scans wait until the odometry has come to
/// their stamp.
class PosesFromWheels {
 public:
  PosesFromWheels(const WheelModel& wheels, LogWriter& writer)
      : odometer_(wheels), writer_(writer) {}

  void add(const SensorMessage& message) {
    if (const auto* ticks = std::get_if<WheelTicks>(&message)) {
      odometer_.add(*ticks);
      waiting_.push_back({ticks->stamp, std::nullopt});
    } else if (const auto* sample = std::get_if<ImuSample>(&message)) {
      odometer_.add(*sample);
    } else if (const auto* scan = std::get_if<LaserScan>(&message)) {
      waiting_.push_back({scan->stamp, *scan});
    }
    write_known(waiting_.size() > kMostWaiting);
  }
  void finish() {
    odometer_.finish();
    write_known(true);
  }
  [[nodiscard]] std::int64_t poses() const { return poses_; }

 private:
  struct Waiting {
    Stamp stamp;
    std::optional<LaserScan> scan;
  };
  static constexpr std::size_t kMostWaiting = 512;

  void write_known(bool all) {
    const auto newest = odometer_.newest();
    while (!waiting_.empty() && (all || (newest && waiting_.front().stamp <= *newest))) {
      const Waiting& first = waiting_.front();
      if (const auto pose = odometer_.pose_at(first.stamp)) {
        writer_.write(OdometryPose{first.stamp, pose->pose});
        ++poses_;
      }
      if (first.scan) writer_.write(*first.scan);
      waiting_.pop_front();
    }
  }

  Odometer odometer_;
  LogWriter& writer_;
  std::deque<Waiting> waiting_;
  std::int64_t poses_ = 0;
};

void count(const SensorMessage& message, ConvertResult& result) {
  if (std::holds_alternative<LaserScan>(message)) ++result.scans;
  if (std::holds_alternative<OdometryPose>(message)) ++result.odometry_poses;
  if (std::holds_alternative<WheelTicks>(message)) ++result.wheel_readings;
  if (std::holds_alternative<ImuSample>(message)) ++result.inertial_readings;
  if (std::holds_alternative<RgbdFrame>(message)) ++result.camera_frames;
}

}  // namespace

ConvertResult convert_log(LogReader& log, LogWriter& writer, const RobotModel& robot,
                          const ConvertOptions& options, const ProgressCallback& progress) {
  ConvertResult result;
  std::optional<PosesFromWheels> from_wheels;
  if (options.wheels_to_poses) from_wheels.emplace(robot.wheels, writer);
  LeftOutCounter counter(log);
  std::int64_t messages = 0;
  bool log_has_poses = false;
  const auto go_on = [&] {
    const ReadProgress read = log.progress();
    return !progress || progress({"converting", read.bytes_done, read.bytes_total, result.scans});
  };
  while (result.complete) {
    const auto message = log.next();
    if (!message) {
      result.complete = go_on();  // the log may have ended because it was told to
      break;
    }
    counter.add(*message);
    count(*message, result);
    // Poses that the log itself has are better known than any that can be computed here.
    if (result.odometry_poses > 0 && result.wheel_readings == 0) log_has_poses = true;
    if (from_wheels && !log_has_poses && !std::holds_alternative<OdometryPose>(*message)) {
      from_wheels->add(*message);
      if (std::holds_alternative<RgbdFrame>(*message)) writer.write(*message);
    } else if (!from_wheels || log_has_poses) {
      if (from_wheels && log_has_poses) {
        from_wheels->finish();
        result.poses_by_dead_reckoning = from_wheels->poses();
        from_wheels.reset();
      }
      writer.write(*message);
    }
    if (++messages % 256 == 0) result.complete = go_on();
  }
  result.left_out = counter.left_out();
  if (from_wheels) {
    from_wheels->finish();
    result.poses_by_dead_reckoning = from_wheels->poses();
  }
  return result;
}

}  // namespace loopstone
