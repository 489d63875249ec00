#pragma once

#include <Eigen/Core>
#include <optional>

#include "loopstone/formats/image.hpp"
#include "loopstone/mapping/map_quality.hpp"
#include "loopstone/report/map_picture.hpp"
#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// Where a map is good and where it is not: the map, pale, and over it the places that hold walls
/// (MapQuality::places). Seen once: left pale. Seen in two visits: green where the walls lie
/// together, through yellow to red where they lie kMapQuality.doubled_m and more apart; violet
/// where beams went through walls. 8-bit RGB; the top is the largest y.
[[nodiscard]] Image draw_quality_picture(const MapResult& result,
                                         const MapPictureOptions& options = {});

/// The places alone, a pixel each, to be laid over a map: 8-bit RGBA, clear where there is no wall.
struct QualityLayer {
  Image image{};
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();  ///< lower left, map frame [m]
  double resolution_m = 0.0;                         ///< side of a pixel
};
/// Nothing where there is no place.
[[nodiscard]] std::optional<QualityLayer> draw_quality_layer(const MapQuality& quality);

}  // namespace loopstone
