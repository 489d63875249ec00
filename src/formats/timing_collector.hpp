#pragma once

#include <cstddef>
#include <vector>

#include "loopstone/formats/log_summary.hpp"

namespace loopstone {

/// Gathers when the records of a sensor came. Memory: 4 bytes a record, up to a bound.
class TimingCollector {
 public:
  static constexpr std::size_t kMostIntervals = std::size_t{1} << 22;

  void add(Stamp stamp);
  [[nodiscard]] TimingSummary finish();

 private:
  TimingSummary timing_;
  std::vector<float> intervals_s_;
};

}  // namespace loopstone
