#pragma once

#include <cstdint>

#include "loopstone/localization/landmark_mapping.hpp"

namespace loopstone {

/// Figures that follow from the landmarks found.
struct LandmarkFigures {
  std::int64_t count = 0;
  std::int64_t round = 0;     ///< with a radius
  double sigma_mean_m = 0.0;  ///< mean of FoundLandmark::sigma_m
  double sightings_mean = 0.0;
};
[[nodiscard]] LandmarkFigures figures_of(const LandmarkMapping& mapping);

}  // namespace loopstone
