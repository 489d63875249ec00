#pragma once

#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "app.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/localization/localization_result.hpp"
#include "loopstone/slam/map_update.hpp"

// What `loopstone live` gives away while it runs. None of it may take the run with it: what can't
// be written on is given up, and said so.

namespace loopstone::app {

/// Where the robot is, a line of JSON for each scan.
class PoseLines {
 public:
  /// \param path  empty: none are wanted; "-" is stdout
  /// Throws DataError when it can't be opened.
  PoseLines(const std::string& path, const AppContext& context);
  ~PoseLines();
  PoseLines(const PoseLines&) = delete;
  PoseLines& operator=(const PoseLines&) = delete;

  void tell(const MapUpdate& update);
  void tell(const LocalizationEstimate& estimate);

 private:
  void write(const std::string& line);

  std::string path_;
  const AppContext& context_;
  std::FILE* file_ = nullptr;
};

/// What comes, as it comes, into a log.
class LiveRecorder {
 public:
  /// \param path  empty: none is wanted
  /// Throws DataError when no file can be made there.
  LiveRecorder(const std::string& path, const RobotModel& robot, const AppContext& context);

  void add(const SensorMessage& message);
  /// Puts the file in its place.
  void finish();

 private:
  template <typename Action>
  void attempt(Action&& action);

  std::string path_;
  const AppContext& context_;
  std::unique_ptr<LogWriter> writer_{};
};

}  // namespace loopstone::app
