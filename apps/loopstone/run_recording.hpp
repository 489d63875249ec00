#pragma once

#include <exception>
#include <optional>
#include <string>

#include "loopstone/report/map_recording.hpp"

namespace loopstone::app {

/// \return why what was asked of a recording could not be done; empty when it was
template <typename Action>
[[nodiscard]] std::string failure_of(Action&& action) {
  try {
    action();
  } catch (const std::exception& error) {
    return std::string("the recording could not be written: ") + error.what();
  }
  return {};
}

/// What --mcap asks for. A recording that can't be written on must not take the map with it: it is
/// given up, and failure() says why.
class RunRecording {
 public:
  /// \param path  empty: none is wanted
  /// Throws DataError when no file can be made there.
  RunRecording(const std::string& path, const RobotModel& robot, const OccupancyOptions& map)
      : path_(path), map_(map) {
    begin_anew(robot);
  }

  /// What was recorded is of no use: the run begins once more, with this robot.
  void begin_anew(const RobotModel& robot) {
    recording_.reset();
    if (!path_.empty() && failure_.empty()) recording_.emplace(path_, robot, map_);
  }

  template <typename... What>
  void add(const What&... what) {
    attempt([&](MapRecording& recording) { recording.add(what...); });
  }
  /// Puts the file in its place.
  void finish(const MapResult& result) {
    attempt([&](MapRecording& recording) { recording.finish(result); });
    recording_.reset();
  }
  /// Empty when there was none.
  [[nodiscard]] const std::string& failure() const { return failure_; }

 private:
  template <typename Action>
  void attempt(Action&& action) {
    if (!recording_) return;
    failure_ = failure_of([&] { action(*recording_); });
    if (!failure_.empty()) recording_.reset();
  }

  std::string path_;
  OccupancyOptions map_;
  std::optional<MapRecording> recording_{};
  std::string failure_{};
};

}  // namespace loopstone::app
