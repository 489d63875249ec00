#pragma once

#include "app.hpp"
#include "live_arguments.hpp"

// What the programs share that map and localise live.

namespace loopstone::app {

/// -o, --map, --initial, --initial-sigma, --continue.
void add_live_map_flags(CLI::App& command, LiveArguments& arguments);
/// All others but those of the sources.
void add_live_flags(CLI::App& command, LiveArguments& arguments, AppContext& context);

/// Maps, or with --map localises, until Ctrl-C. Throws UsageError for flags that exclude each
/// other.
[[nodiscard]] ExitCode run_live(const LiveArguments& arguments, const AppContext& context);

}  // namespace loopstone::app
