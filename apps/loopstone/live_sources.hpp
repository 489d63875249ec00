#pragma once

#include <string>
#include <vector>

#include "app.hpp"
#include "live_arguments.hpp"
#include "loopstone/live/live_log.hpp"

namespace loopstone::app {

/// The sources that a user names, in their order, then those that are given. Throws UsageError for
/// names that make no sense.
[[nodiscard]] std::vector<LiveSource> live_sources(const LiveArguments& arguments);

/// Their names in a row.
[[nodiscard]] std::string names_of_sources(const LiveArguments& arguments);

}  // namespace loopstone::app
