#pragma once

#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// Figures that follow from the map.
struct MapFigures {
  double known_area_m2 = 0.0;  ///< of the cells that were observed
  double free_area_m2 = 0.0;
  double width_m = 0.0;
  double height_m = 0.0;
};
[[nodiscard]] MapFigures figures_of(const OccupancyMap& map);

/// numerator / denominator; 0 when the denominator is.
[[nodiscard]] inline double ratio_or_zero(double numerator, double denominator) {
  return denominator > 0.0 ? numerator / denominator : 0.0;
}

}  // namespace loopstone
