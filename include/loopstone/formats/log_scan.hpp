#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/base/stamp.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// Which scan of which log: "LOG#120", the scan number 120 (from 0), or "LOG@1000.5", the scan
/// nearest to that second of the log's clock, or "LOG@+12.5", to that many seconds after its first
/// scan. A folder with several sets needs its number first: "DIR#20#120", "DIR#20@+12.5"; "DIR#120"
/// is a scan of the folder's only set.
struct ScanName {
  std::string log;
  std::optional<std::int64_t> index{};
  std::optional<Duration> time{};  ///< since the clock's zero, or since the first scan
  bool after_first_scan = false;
};

/// Nothing when the text names no scan: it has no #number or @time behind a path that exists, or is
/// itself a path that does.
[[nodiscard]] std::optional<ScanName> parse_scan_name(const std::string& text);

/// A scan of a log and what the log knows of the robot at that moment.
struct LogScan {
  LaserScan scan;
  std::int64_t index = 0;
  Pose2 robot_T_lidar;
  Tangent2 velocity =
      Tangent2::Zero();  ///< by odometry, robot frame [m/s, m/s, rad/s]; zero without
  std::optional<Pose2> odom_T_robot{};  ///< counted from the log's beginning
};

/// Reads a log up to a scan. Scans are those of the first laser, in time order.
/// \param robot        wheels and mounts
/// \param robot_given  the user named that robot: it beats what the log says about itself
/// Throws DataError when the log has no such scan, or none within half a second of the time;
/// ReadingStopped.
[[nodiscard]] LogScan read_log_scan(const ScanName& name, const RobotModel& robot,
                                    bool robot_given = false, const LogOptions& options = {});

}  // namespace loopstone
