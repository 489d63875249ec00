#pragma once

#include "loopstone/formats/ros_map.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/mapping/occupancy.hpp"

namespace loopstone {

/// On what share of visits something stands in each cell that was seen [%].
[[nodiscard]] CellStates movable_mask(const Grid<float>& movable, const OccupancyMap& map);

}  // namespace loopstone
