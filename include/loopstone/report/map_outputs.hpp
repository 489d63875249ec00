#pragma once

#include <string>

#include "loopstone/localization/landmark_mapping.hpp"
#include "loopstone/mapping/floor_texture.hpp"
#include "loopstone/report/edit_outputs.hpp"
#include "loopstone/report/run_info.hpp"
#include "loopstone/report/site_figures.hpp"
#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// What else was made of a log, where it was asked for; null: it was not.
struct MapExtras {
  const FloorTexture* texture = nullptr;
  const LandmarkMapping* landmarks = nullptr;
  const EditOutputs* edits = nullptr;  ///< the map is one that somebody edited
  const SiteFigures* site = nullptr;   ///< of the grids beside the map of a site
};

/// Writes trajectory.tum, odometry.tum, graph.g2o, map.pgm, map.yaml, map.png, report.html,
/// summary.json, options.toml and decisions.toml. All of them are complete on disk before the first
/// gets its name. Where map, pictures or report can't be made or written (too large, the disk is
/// full), trajectories, graph, loop closures, options, decisions and a summary.json with
/// `complete: false` are left, and this throws; where not even those fit, the folder stays as it
/// was. An older set of results is replaced as a whole. Makes the folder when it is missing. Throws
/// UsageError when it holds something and `force` is false, else std::runtime_error naming what
/// can't be written.
/// \param extras  of the floor: texture.png and what belongs to it as well (texture_outputs.hpp);
///                of landmarks: landmarks.csv; of edits: edits.toml and the masks of zones
void write_map_outputs(const MapResult& result, const RunInfo& info, const std::string& out_dir,
                       const MapExtras& extras = {});

/// The text of summary.json: one object, every figure of the run, units in the key names, keys in a
/// fixed order.
/// \param extras  of each that is given an object with its figures: "texture", "landmarks",
///                "edits", "site"
[[nodiscard]] std::string format_summary(const MapResult& result, const RunInfo& info,
                                         const MapExtras& extras = {});

}  // namespace loopstone
