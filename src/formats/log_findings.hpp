#pragma once

#include <string>
#include <vector>

#include "loopstone/formats/log_summary.hpp"

namespace loopstone {

/// What is remarkable about a log, worst first. `notes` and `warnings` are those of the reader.
[[nodiscard]] std::vector<Finding> find_suspicious(const LogSummary& summary,
                                                   const std::vector<std::string>& notes,
                                                   const std::vector<std::string>& warnings);

}  // namespace loopstone
