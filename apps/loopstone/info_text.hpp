#pragma once

#include <string>

#include "loopstone/formats/log_summary.hpp"

namespace loopstone::app {

/// What a log's summary tells a person: tables with units, in colours on a terminal.
[[nodiscard]] std::string info_text(const std::string& path, const LogSummary& summary);

}  // namespace loopstone::app
