#pragma once

#include <string>

#include "app.hpp"
#include "loopstone/report/map_outputs.hpp"
#include "loopstone/report/run_info.hpp"
#include "loopstone/slam/map_result.hpp"

namespace loopstone::app {

/// Where the results of a run are.
struct MapPlaces {
  std::string out{};
  std::string mcap{};     ///< empty: there is none
  std::string goes_on{};  ///< what is said behind "interrupted"
};

/// Prints warnings and figures of a finished map; the exit code says how the run ended. Throws
/// std::runtime_error with what failed.
[[nodiscard]] ExitCode tell_map(const MapResult& result, const MapExtras& extras,
                                const RunInfo& info, const MapPlaces& places,
                                const AppContext& context);

}  // namespace loopstone::app
