#pragma once

#include <string>

#include "loopstone/localization/landmark_drive.hpp"
#include "loopstone/report/run_info.hpp"

namespace loopstone {

/// Writes trajectory.tum, odometry.tum, graph.g2o, landmarks.csv, map.png, report.html,
/// summary.json, options.toml and decisions.toml of a drive among landmarks that has no scans. All
/// of them are complete on disk before the first gets its name. Makes the folder when it is
/// missing. Throws UsageError when it holds something and `info.force` is false, DataError naming
/// the file that can't be written.
/// \param complete  false: the user interrupted
void write_landmark_outputs(const LandmarkDriveMap& map, const RunInfo& info, bool complete,
                            const std::string& out_dir);

/// The text of summary.json: keys as in that of a map, as far as there are any.
[[nodiscard]] std::string format_summary(const LandmarkDriveMap& map, const RunInfo& info,
                                         bool complete);

}  // namespace loopstone
