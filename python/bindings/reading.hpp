#pragma once

#include <nanobind/nanobind.h>

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/formats/log_reader.hpp"
#include "robot.hpp"

namespace loopstone::python {

/// A log by its name, and how it is read.
struct Log {
  std::string path{};
  LogOptions how{};
  std::optional<Robot> robot{};  ///< beats what the log says of it

  [[nodiscard]] std::unique_ptr<LogReader> open(std::function<bool()> stop) const;
  /// \param ahead  read by a thread of its own
  [[nodiscard]] std::unique_ptr<LogReader> open_ahead(std::function<bool()> stop,
                                                      bool pictures) const;
  /// The given one, else what the log states of it; its wheels as the log's are to be read.
  [[nodiscard]] RobotModel robot_of(const LogReader& reader) const;
};

}  // namespace loopstone::python
