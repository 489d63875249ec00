#pragma once

#include <string>

#include "loopstone/mapping/floor_texture.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/report/run_info.hpp"

namespace loopstone {

/// summary.json of a texture: areas, frames, the camera's true mount and clock; units in the names.
[[nodiscard]] std::string format_texture_summary(const FloorTexture& texture, const RunInfo& info);

/// Writes texture.png, texture.yaml, texture.pgw, coverage.png, texture_map.png, cloud.ply when
/// there is one, options.toml and summary.json into a folder. Nothing appears before all is on
/// disk.
/// \param map  walls for texture_map.png; may be empty
/// Throws UsageError when the folder holds something and info.force is not set, DataError when it
/// can't be written.
void write_texture_outputs(const FloorTexture& texture, const OccupancyMap& map,
                           const Trajectory& trajectory, const RunInfo& info,
                           const std::string& out_dir);

}  // namespace loopstone
