#pragma once

#include <chrono>
#include <ctime>

#include "loopstone/report/peak_memory.hpp"
#include "loopstone/report/run_info.hpp"

namespace loopstone::python {

/// What a run took so far: of this process, all threads.
class Cost {
 public:
  void note(RunInfo& info) const {
    info.wall_time_s = std::chrono::duration<double>(Clock::now() - start_).count();
    info.cpu_time_s = cpu_seconds() - cpu_s_;
    info.peak_memory_bytes = peak_memory_bytes();
  }

 private:
  using Clock = std::chrono::steady_clock;
  static double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

  Clock::time_point start_ = Clock::now();
  double cpu_s_ = cpu_seconds();
};

}  // namespace loopstone::python
