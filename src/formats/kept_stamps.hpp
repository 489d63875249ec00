#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// The records of a sensor whose stamps increase, and why the others were left out.
struct KeptStamps {
  struct Refused {
    std::int64_t index;
    std::string reason;
    std::string name{};  ///< what people call the record; empty: "record N", counted from 1
  };
  std::vector<Stamp> stamps{};          ///< strictly increasing
  std::vector<std::int64_t> indices{};  ///< the record that each belongs to
  std::vector<Refused> refused{};
};

/// Keeps as many records as can be kept in order: the longest strictly increasing subsequence
/// (Fredman 1975), so that one stamp far in the future costs one record and not all that follow.
/// O(n log n).
[[nodiscard]] KeptStamps keep_increasing(std::span<const double> seconds);

}  // namespace loopstone
