#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/formats/left_out.hpp"

namespace loopstone {

/// How long poses were waited for in a replay at a log's own pace.
struct LatencyFigures {
  double median_s = 0.0;
  double p99_s = 0.0;  ///< 99 of 100 came sooner
  double worst_s = 0.0;
};

/// How long after it a scan's pose was known.
struct PaceFigures {
  double speed = 1.0;        ///< of the replay; 1: as recorded
  LatencyFigures arrival{};  ///< the scan arrived
  LatencyFigures
      computing{};  ///< the message arrived that the scan waited for: odometry of its time
};

/// What the program knows about a run that the result does not.
struct RunInfo {
  std::string log_path;      ///< as the user gave it
  std::string command_line;  ///< empty when the library was called directly
  std::string options_toml;  ///< the effective options, written as options.toml
  std::string version;       ///< of Loopstone
  double wall_time_s =
      0.0;  ///< from opening the log to the finished result, without the writing of these files
  double cpu_time_s = 0.0;  ///< of all threads
  /// Of the process so far. Unless 0, what is written tells the peak of when maps and pictures are
  /// made, too.
  std::int64_t peak_memory_bytes = 0;
  LeftOut left_out{};  ///< of the log, as far as it was read
  /// Those of the result's warnings that the log itself gives reason for, whatever the map.
  std::vector<std::string> log_warnings{};
  int threads = 0;
  std::optional<PaceFigures> pace{};  ///< of a replay in real time
  bool force = false;                 ///< files of an earlier run may be replaced
  /// What could not be made of the finished result, and why; it makes the files incomplete.
  std::string failure{};
  /// All that determines the result beside version and options, by name: two runs that agree in it
  /// have the same files.
  using Terms = std::vector<std::pair<std::string, std::string>>;
  Terms terms{};
};

}  // namespace loopstone
