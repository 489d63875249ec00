#pragma once

#include <memory>
#include <optional>
#include <string>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// A log by its name, and how it is read. It can be read more than once, unless it is a stream.
struct LogSource {
  std::string path{};
  LogOptions how{};
  std::optional<RobotModel> robot{};  ///< of who asks; beats what the log says of its robot

  /// Throws DataError, UsageError as open_log() does.
  [[nodiscard]] std::unique_ptr<LogReader> open() const;
  /// The same, read by a thread of its own where there may be several.
  [[nodiscard]] std::unique_ptr<LogReader> open_ahead(Threads threads) const;
  /// From the beginning, after open() has told all problems: without them, and without pictures.
  [[nodiscard]] std::unique_ptr<LogReader> open_again() const;

  /// The given one, else what the log states of it; its wheels as the log's are to be read.
  [[nodiscard]] RobotModel robot_of(const LogReader& reader) const;
  /// What scans say of their laser's place on the robot counts.
  [[nodiscard]] bool mounts_from_log() const { return !robot; }
};

}  // namespace loopstone
