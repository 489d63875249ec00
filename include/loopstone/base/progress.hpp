#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

namespace loopstone {

/// How far a long piece of work has come.
struct Progress {
  std::string_view step;    ///< what is being done, for people: "mapping"
  std::int64_t done = 0;    ///< in the unit of total
  std::int64_t total = 0;   ///< 0 when unknown
  std::int64_t scans = 0;   ///< scans finished so far, where that makes sense
  double recorded_s = 0.0;  ///< time of the recording dealt with so far [s], where that makes sense
};

/// Told how far the work is; returns false to ask it to stop at the next good place. May be empty.
using ProgressCallback = std::function<bool(const Progress&)>;

}  // namespace loopstone
