#pragma once

#include <cstdint>

#include "loopstone/grid/grid.hpp"
#include "loopstone/grid/sphere_caster.hpp"
#include "loopstone/localization/likelihood_field_model.hpp"
#include "loopstone/localization/localization_map.hpp"
#include "loopstone/registration/map_match.hpp"

namespace loopstone {

/// Beams are followed no farther on the map.
inline constexpr double kCastMaxM = 60.0;

struct LocalizationMap::Tables {
  Grid<std::int8_t> occupancy;
  MapSearch search;              ///< for finding scans, and for registering them
  LikelihoodFieldModel weigher;  ///< for weighing particles of a place against each other
  LikelihoodFieldModel judge;    ///< for weighing places against each other
  SphereCaster caster;           ///< for what should be seen
  double free_area_m2 = 0.0;

  explicit Tables(Grid<std::int8_t> map);
};

}  // namespace loopstone
