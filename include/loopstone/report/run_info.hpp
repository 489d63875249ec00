#pragma once

#include <cstdint>
#include <string>

namespace loopstone {

/// What the program knows about a run that the result does not.
struct RunInfo {
  std::string log_path;      ///< as the user gave it
  std::string command_line;  ///< empty when the library was called directly
  std::string options_toml;  ///< the effective options, written as options.toml
  std::string version;       ///< of Loopstone
  double wall_time_s =
      0.0;  ///< from opening the log to the finished result, without the writing of these files
  double cpu_time_s = 0.0;  ///< of all threads
  std::int64_t peak_memory_bytes = 0;
  std::int64_t records_skipped = 0;
  int threads = 0;
  bool force = false;  ///< files of an earlier run may be replaced
};

}  // namespace loopstone
