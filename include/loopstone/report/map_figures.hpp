#pragma once

#include "loopstone/mapping/occupancy.hpp"

namespace loopstone {

/// Figures that follow from the map.
struct MapFigures {
  double known_area_m2 = 0.0;  ///< of the cells that were observed
  double free_area_m2 = 0.0;
  double width_m = 0.0;
  double height_m = 0.0;
};
/// Cost: one look at each cell.
[[nodiscard]] MapFigures figures_of(const OccupancyMap& map);

}  // namespace loopstone
