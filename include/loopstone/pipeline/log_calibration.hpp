#pragma once

#include <optional>
#include <string>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/formats/log_summary.hpp"
#include "loopstone/pipeline/cut_log.hpp"
#include "loopstone/pipeline/log_source.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_result.hpp"

// What a log tells of the robot that wrote it: where its laser sits, how its beams go round, how
// its wheels count.

namespace loopstone {

/// Wheels by themselves, without a gyro: what they tell of radius and track.
struct WheelFindings {
  Calibration found{};
  WheelModel wheels{};  ///< with what is certainly wrong put right
};

struct RobotFindings {
  RobotModel given{};      ///< as it was mapped: beams that are off are put right already
  RobotModel corrected{};  ///< with all that is certainly wrong put right
  MapResult map{};         ///< of a mapping without loops; its calibration is what was found
  std::optional<WheelFindings> wheels{};
  LogSummary log{};  ///< what was read
  bool interrupted = false;

  /// What scans say of their laser's place on the robot is wrong.
  [[nodiscard]] bool mount_corrected() const {
    return map.calibration.mount_is_off() && !map.calibration.several_mounts;
  }
  /// Nor does the log mean that the laser is the robot's centre: a map would be corrected.
  [[nodiscard]] bool mount_is_certain() const {
    return mount_corrected() && map.calibration.is_corrected;
  }
};

/// Reads a log, and once more when its beams are off (slam/robot_correction.hpp).
/// \param reader  of the source, at its beginning
/// \param robot   as it is told
/// Cost: as mapping it without closing loops. Throws DataError when nothing can be made of the log.
[[nodiscard]] RobotFindings calibrate_log(const LogSource& source, LogReader& reader,
                                          const RobotModel& robot, const LogCut& cut,
                                          MapOptions options, Threads threads = {},
                                          const ReadingWatch& watch = {});

/// Throws DataError when nothing was found, which is said of the log.
void require_findings(const RobotFindings& findings, const std::string& path);

/// The robot that wrote a log.
struct DrivenRobot {
  RobotModel model{};
  bool mounts_from_log = true;  ///< what scans say of their laser's place on it counts
  std::vector<std::string> warnings{};
};

/// As the first five minutes of its driving tell it, for who localises it (docs/calibration.md);
/// one that was given with the source is as it is.
/// \param told  LogSource::robot_of(). Throws as calibrate_log() does.
[[nodiscard]] DrivenRobot robot_as_driven(const LogSource& source, const RobotModel& told,
                                          LogCut cut, Threads threads = {},
                                          const ReadingWatch& watch = {});

}  // namespace loopstone
