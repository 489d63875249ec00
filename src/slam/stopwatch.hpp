#pragma once

#include <chrono>

namespace loopstone {

/// Seconds since it was made, for the figures of a run; never part of a result.
class Stopwatch {
 public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace loopstone
