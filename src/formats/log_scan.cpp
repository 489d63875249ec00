#include "loopstone/formats/log_scan.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <string_view>
#include <utility>

#include "formats/text_numbers.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/decimal_stamp.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/odometry/scan_queue.hpp"
#include "loopstone/sensor/mounted_scan.hpp"

namespace loopstone {
namespace {

/// How far from the time that was asked for a scan may be.
constexpr Duration kNearEnough{500'000'000};

bool exists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

/// A path, or a folder and the number of a set.
bool names_log(const std::string& text) {
  if (exists(text)) return true;
  const std::size_t hash = text.rfind('#');
  return hash != text.npos && parse_integer(std::string_view(text).substr(hash + 1)) &&
         exists(text.substr(0, hash));
}

/// Looks at one scan after the other and keeps the one that was asked for.
class ScanPicker {
 public:
  explicit ScanPicker(const ScanName& name) : name_(name) {}

  /// True when no later scan can be it.
  bool take(LogScan scan) {
    if (!first_) first_ = scan.scan.stamp;
    last_ = scan.scan.stamp;
    scan.index = count_++;
    if (name_.index) {
      if (scan.index != *name_.index) return false;
      found_ = std::move(scan);
      return true;
    }
    const bool beyond = scan.scan.stamp >= wanted();
    if (!found_ || distance(scan.scan.stamp) < distance(found_->scan.stamp))
      found_ = std::move(scan);
    return beyond && distance(found_->scan.stamp) <= kNearEnough;
  }

  [[nodiscard]] LogScan result() && {
    if (count_ == 0) throw DataError({name_.log}, "the log has no scans");
    if (name_.index && !found_) {
      throw DataError({name_.log}, fmt::format("has no scan {}: it has {}, numbered from 0",
                                               *name_.index, count_));
    }
    if (!name_.index && distance(found_->scan.stamp) > kNearEnough) {
      throw DataError({name_.log},
                      fmt::format("has no scan within half a second of {}: its scans "
                                  "go from {} to {}",
                                  format_decimal_stamp(wanted()), format_decimal_stamp(*first_),
                                  format_decimal_stamp(last_)));
    }
    return std::move(*found_);
  }

 private:
  [[nodiscard]] Stamp wanted() const {
    return (name_.after_first_scan ? *first_ : Stamp{}) + *name_.time;
  }
  [[nodiscard]] Duration distance(Stamp stamp) const {
    const Duration d = stamp - wanted();
    return {d.nanoseconds < 0 ? -d.nanoseconds : d.nanoseconds};
  }

  ScanName name_;
  std::optional<Stamp> first_{};
  Stamp last_{};
  std::int64_t count_ = 0;
  std::optional<LogScan> found_{};
};

}  // namespace

std::optional<ScanName> parse_scan_name(const std::string& text) {
  const std::size_t mark = text.find_last_of("#@");
  if (mark == text.npos || mark == 0 || exists(text)) return std::nullopt;
  ScanName name;
  name.log = text.substr(0, mark);
  if (!names_log(name.log)) return std::nullopt;
  std::string_view value = std::string_view(text).substr(mark + 1);
  if (text[mark] == '#') {
    name.index = parse_integer(value);
    if (!name.index || *name.index < 0) {
      throw UsageError("'" + text + "': after the last '#' the number of a scan was expected");
    }
    return name;
  }
  name.after_first_scan = value.starts_with('+');
  if (name.after_first_scan) value.remove_prefix(1);
  const std::optional<Stamp> time = parse_stamp(value);
  if (!time) throw UsageError("'" + text + "': after '@' a time in seconds was expected");
  name.time = Duration{time->nanoseconds};
  return name;
}

LogScan read_log_scan(const ScanName& name, const RobotModel& robot, bool robot_given,
                      const LogOptions& options) {
  const auto log = open_log(name.log, options);
  ScanQueue queue(log->wheels(robot.wheels));
  ScanPicker picker(name);
  std::optional<LogScan> before;
  const auto take = [&](const LaserScan& scan) {
    if (scan.lidar != 0) return false;
    const auto mounted = as_mounted(scan, robot_given ? robot : log->robot(robot));
    LogScan read{.scan = mounted ? *mounted : scan};
    if (robot_given) read.scan.robot_T_lidar.reset();
    read.robot_T_lidar = mount_of(read.scan, robot_given ? robot : log->robot(robot));
    if (const auto pose = queue.odometer().pose_at(read.scan.stamp)) read.odom_T_robot = pose->pose;
    if (before && before->odom_T_robot && read.odom_T_robot) {
      const double seconds = (read.scan.stamp - before->scan.stamp).seconds();
      const Pose2 motion = before->odom_T_robot->inverse() * *read.odom_T_robot;
      if (seconds > 0.0) read.velocity = loopstone::log(motion) / seconds;
    }
    before = read;
    return picker.take(std::move(read));
  };
  bool done = false;
  while (!done) {
    auto message = log->next();
    if (message) {
      queue.add(*message);
    } else {
      queue.finish();
    }
    while (!done) {
      auto scan = queue.next();
      if (!scan) break;
      done = take(*scan);
    }
    if (!message) break;
  }
  if (!done && options.stop && options.stop()) throw ReadingStopped();
  return std::move(picker).result();
}

}  // namespace loopstone
