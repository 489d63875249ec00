#pragma once

#include "loopstone/formats/image.hpp"
#include "loopstone/report/map_picture.hpp"
#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// Where a map is good and where it is not: the map, pale, and over it the places that hold walls
/// (MapQuality::places). Seen once: left pale. Seen in two visits: green where the walls lie
/// together, through yellow to red where they lie kMapQuality.doubled_m and more apart; violet
/// where beams went through walls. 8-bit RGB; the top is the largest y.
[[nodiscard]] Image draw_quality_picture(const MapResult& result,
                                         const MapPictureOptions& options = {});

}  // namespace loopstone
