#pragma once

#include <string>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/base/parallel_for.hpp"
#include "loopstone/localization/localization_map.hpp"

namespace loopstone::app {

/// --map names the file or its folder: the file.
[[nodiscard]] std::string map_yaml_of(const std::string& path);

/// The map of --map, made ready: of a site the map of today. Throws DataError with path and reason.
[[nodiscard]] LocalizationMap read_known_map(const std::string& path, const MemoryBudget& budget,
                                             Threads threads);

}  // namespace loopstone::app
