#pragma once

#include <cstddef>

#include "loopstone/mapping/submap.hpp"

namespace loopstone {

/// A submap that is full, and the key scans that are in it.
struct FinishedSubmap {
  FrozenSubmap submap;
  std::size_t first_key = 0;  ///< its frame is this key scan's pose
  std::size_t last_key = 0;
  /// Of the path: a new one begins where the laser can't tell how it goes on.
  std::size_t piece = 0;
};

}  // namespace loopstone
