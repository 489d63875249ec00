#pragma once

#include <cstdint>
#include <string>

#include "loopstone/base/progress.hpp"
#include "loopstone/formats/left_out.hpp"
#include "loopstone/formats/log_format.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

/// What was read, and made of it. What the new format has no place for is told by
/// LogWriter::notes().
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

/// Copies a log to a writer, which is not finished: the caller decides what becomes of an
/// interrupted one. Where the target holds poses but no wheel counts (CARMEN), counts and gyro
/// become poses by dead reckoning, at every wheel reading and scan, unless the log has poses
/// itself.
/// \param held   what the writer's format has a place for (LogFormat::holds)
/// \param robot  the robot of the log; its wheels are needed for dead reckoning
/// Throws what the reader and the writer throw. Cost: O(messages); bounded memory.
[[nodiscard]] ConvertResult convert_log(LogReader& log, LogWriter& writer, const LogContents& held,
                                        const RobotModel& robot,
                                        const ProgressCallback& progress = {});

/// A log is not written over the one that it is made of, nor over what somebody may want to keep.
/// \param source           the log that is read, as open_log() takes it
/// \param may_overwrite    what is there, but for the source
/// Throws UsageError that names the file.
void require_free_place(const LogTarget& target, const std::string& source, bool may_overwrite);

}  // namespace loopstone
