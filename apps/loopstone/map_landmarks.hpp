#pragma once

#include "app.hpp"
#include "loopstone/localization/landmark_mapping.hpp"
#include "map_pipeline.hpp"
#include "result.hpp"

// `loopstone map --landmarks`: what differs from a map of surfaces alone.

namespace loopstone::app {

/// --landmarks, --nameless, --reflector-threshold.
void add_landmark_map_flags(CLI::App& command, LandmarkMapFlags& flags);

void add_landmark_rows(const LandmarkMapping& mapping, Result& table);

/// A map of a log that has landmarks and odometry, and no scans: path and landmarks alone.
[[nodiscard]] ExitCode map_mrclam(const MapArguments& arguments, const AppContext& context);

}  // namespace loopstone::app
