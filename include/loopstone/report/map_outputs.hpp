#pragma once

#include <string>

#include "loopstone/mapping/floor_texture.hpp"
#include "loopstone/report/run_info.hpp"
#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// Writes trajectory.tum, odometry.tum, graph.g2o, map.pgm, map.yaml, map.png, report.html,
/// summary.json, options.toml and decisions.toml. All of them are complete on disk before the first
/// gets its name. Where map, pictures or report can't be made or written (too large, the disk is
/// full), trajectories, graph, loop closures, options, decisions and a summary.json with
/// `complete: false` are left, and this throws; where not even those fit, the folder stays as it
/// was. An older set of results is replaced as a whole. Makes the folder when it is missing. Throws
/// UsageError when it holds something and `force` is false, else std::runtime_error naming what
/// can't be written.
/// \param texture  when given: texture.png and what belongs to it as well (texture_outputs.hpp)
void write_map_outputs(const MapResult& result, const RunInfo& info, const std::string& out_dir,
                       const FloorTexture* texture = nullptr);

/// The text of summary.json: one object, every figure of the run, units in the key names, keys in a
/// fixed order.
/// \param texture  when given: an object "texture" with its figures
[[nodiscard]] std::string format_summary(const MapResult& result, const RunInfo& info,
                                         const FloorTexture* texture = nullptr);

}  // namespace loopstone
