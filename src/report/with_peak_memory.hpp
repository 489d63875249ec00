#pragma once

#include <algorithm>

#include "loopstone/report/peak_memory.hpp"
#include "loopstone/report/run_info.hpp"

namespace loopstone {

/// A run whose caller tells its peak memory, with the peak until now: pictures may take more than
/// what they show.
[[nodiscard]] inline RunInfo with_peak_memory(RunInfo info) {
  if (info.peak_memory_bytes > 0)
    info.peak_memory_bytes = std::max(info.peak_memory_bytes, peak_memory_bytes());
  return info;
}

}  // namespace loopstone
