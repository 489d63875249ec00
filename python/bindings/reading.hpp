#pragma once

#include <nanobind/nanobind.h>

#include <functional>
#include <optional>
#include <string>

#include "loopstone/formats/log_reader.hpp"
#include "loopstone/pipeline/log_source.hpp"
#include "robot.hpp"

namespace loopstone::python {

/// A log by its name, and how it is read.
struct Log {
  std::string path{};
  LogOptions how{};
  std::optional<Robot> robot{};  ///< beats what the log says of it

  /// \param stop  asked now and then, true ends the reading
  [[nodiscard]] LogSource source(std::function<bool()> stop) const;
};

}  // namespace loopstone::python
