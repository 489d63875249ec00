#pragma once

#include "loopstone/formats/ros_map.hpp"

namespace loopstone {

/// A run that ended before its first scan still leaves a map that every tool can open: one unknown
/// cell.
[[nodiscard]] inline CellStates states_to_write(const OccupancyMap& map) {
  if (!map.log_odds.empty()) return cell_states(map);
  const GridFrame frame{.resolution = OccupancyOptions{}.resolution_m, .columns = 1, .rows = 1};
  return CellStates(frame, kUnknownCell);
}

}  // namespace loopstone
