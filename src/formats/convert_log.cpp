#include "loopstone/formats/convert_log.hpp"

#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_files.hpp"
#include "loopstone/formats/log_summary.hpp"
#include "loopstone/formats/output_place.hpp"
#include "loopstone/odometry/odometer.hpp"

namespace loopstone {
namespace {

/// Turns wheel counts and gyro into a pose at every wheel reading and scan. What the target holds
/// beside poses waits, in order, until the odometry has come to its stamp.
class PosesFromWheels {
 public:
  PosesFromWheels(const WheelModel& wheels, const LogContents& held, LogWriter& writer)
      : odometer_(wheels), held_(held), writer_(writer) {}

  void add(const SensorMessage& message) {
    if (const auto* ticks = std::get_if<WheelTicks>(&message)) {
      odometer_.add(*ticks);
      waiting_.push_back({ticks->stamp, true, std::nullopt});
    } else if (const auto* sample = std::get_if<ImuSample>(&message)) {
      odometer_.add(*sample);
      if (held_.imu_samples) waiting_.push_back({sample->stamp, false, message});
    } else if (holds(held_, message)) {
      const bool is_scan = std::holds_alternative<LaserScan>(message);
      waiting_.push_back({stamp_of(message), is_scan, message});
    } else {
      writer_.write(message);  // which counts it
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
    bool wants_pose = false;
    std::optional<SensorMessage> message{};
  };
  static constexpr std::size_t kMostWaiting = 512;

  void write_known(bool all) {
    const auto newest = odometer_.newest();
    while (!waiting_.empty() && (all || (newest && waiting_.front().stamp <= *newest))) {
      const Waiting& first = waiting_.front();
      if (const auto pose = odometer_.pose_at(first.stamp); pose && first.wants_pose) {
        writer_.write(OdometryPose{first.stamp, pose->pose});
        ++poses_;
      }
      if (first.message) writer_.write(*first.message);
      waiting_.pop_front();
    }
  }

  Odometer odometer_;
  LogContents held_;
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

/// Gives each message to the writer, or to the dead reckoning on its way there.
class Copier {
 public:
  Copier(LogWriter& writer, const LogContents& held, const RobotModel& robot) : writer_(writer) {
    if (held.odometry_poses && !held.wheel_ticks) {
      from_wheels_.emplace(robot.wheels, held, writer);
    }
  }

  void add(const SensorMessage& message, ConvertResult& result) {
    count(message, result);
    // Poses that the log itself has are better known than any that can be computed here.
    if (result.odometry_poses > 0 && result.wheel_readings == 0) finish(result);
    if (!from_wheels_) {
      writer_.write(message);
    } else if (!std::holds_alternative<OdometryPose>(message)) {
      from_wheels_->add(message);
    }
  }
  void finish(ConvertResult& result) {
    if (!from_wheels_) return;
    from_wheels_->finish();
    result.poses_by_dead_reckoning = from_wheels_->poses();
    from_wheels_.reset();
  }

 private:
  LogWriter& writer_;
  std::optional<PosesFromWheels> from_wheels_{};
};

}  // namespace

ConvertResult convert_log(LogReader& log, LogWriter& writer, const LogContents& held,
                          const RobotModel& robot, const ProgressCallback& progress) {
  ConvertResult result;
  Copier copier(writer, held, robot);
  LeftOutCounter counter(log);
  std::int64_t messages = 0;
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
    copier.add(*message, result);
    if (++messages % 256 == 0) result.complete = go_on();
  }
  result.left_out = counter.left_out();
  copier.finish(result);
  return result;
}

void require_free_place(const LogTarget& target, const std::string& source, bool may_overwrite) {
  const std::vector<std::string> read = LogFiles(source).paths();
  for (const std::string& path : log_parts(target).files) {
    std::error_code ignored;
    for (const std::string& other : read) {
      if (std::filesystem::equivalent(path, other, ignored))
        throw UsageError(path + ": this is the log that is read; name another file");
    }
    if (!may_overwrite) require_free_name(path);
  }
}

}  // namespace loopstone
