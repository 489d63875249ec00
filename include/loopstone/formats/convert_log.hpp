#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "loopstone/base/progress.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

struct ConvertOptions {
  /// The target holds poses, not wheel counts (CARMEN): wheel counts and gyro become poses by dead reckoning.
  bool wheels_to_poses = false;
};

struct ConvertResult {
  std::int64_t scans = 0;
  std::int64_t odometry_poses = 0;
  std::int64_t wheel_readings = 0;
  std::int64_t inertial_readings = 0;
  std::int64_t camera_frames = 0;
  std::int64_t poses_by_dead_reckoning = 0;
  LeftOut left_out{};
  bool complete = true;  ///< false when it was interrupted
};

/// Copies a log to a writer, which is not finished: the caller decides what becomes of an interrupted one.
/// \param robot  the robot of the log; its wheels are needed for dead reckoning
[[nodiscard]] ConvertResult convert_log(LogReader& log, LogWriter& writer, const RobotModel& robot,
                                        const ConvertOptions& options = {},
                                        const ProgressCallback& progress = {});

}  // namespace loopstone
