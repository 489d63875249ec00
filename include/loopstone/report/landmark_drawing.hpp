#pragma once

#include <cstdint>
#include <span>

#include "loopstone/grid/grid.hpp"
#include "loopstone/localization/landmark_map.hpp"

namespace loopstone {

/// A map to look at for where there is none but landmarks: free all around, occupied where a
/// landmark stands, drawn at least a hand wide. In percent, as the pictures and pages of a
/// localisation take it.
/// \param margin_m  around the landmarks
/// Cells are 5 cm, larger where there would be more than 4 million.
[[nodiscard]] Grid<std::int8_t> drawn_landmarks(std::span<const MappedLandmark> landmarks,
                                                double margin_m = 5.0);

}  // namespace loopstone
