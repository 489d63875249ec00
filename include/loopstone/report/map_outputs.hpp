#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// What the program knows about a run that the mapper does not.
struct RunInfo {
  std::string log_path;      ///< as the user gave it
  std::string command_line;  ///< empty when the library was called directly
  std::string options_toml;  ///< the effective options, written as options.toml
  std::string version;       ///< of Loopstone
  double wall_time_s =
      0.0;  ///< from opening the log to the finished map, without the writing of these files
  double cpu_time_s = 0.0;  ///< of all threads
  std::int64_t peak_memory_bytes = 0;
  std::int64_t records_skipped = 0;
  int threads = 0;
  bool force = false;  ///< files of an earlier run may be replaced
};

/// Writes trajectory.tum, odometry.tum, graph.g2o, map.pgm, map.yaml, map.png, report.html, summary.json and options.toml.
/// All of them are complete on disk before the first gets its name, so a full disk leaves none of them behind.
/// Makes the folder when it is missing. Throws UsageError when it holds something and `force` is false, DataError
/// naming the file that can't be written.
void write_map_outputs(const MapResult& result, const RunInfo& info, const std::string& out_dir);

/// The text of summary.json: one object, every figure of the run, units in the key names, keys in a fixed order.
[[nodiscard]] std::string format_summary(const MapResult& result, const RunInfo& info);

}  // namespace loopstone
