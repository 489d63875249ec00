#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// About how large quality.png is: places of 50 cm need fewer pixels than walls.
inline constexpr int kQualitySidePx = 1200;

/// The object "quality" of summary.json.
[[nodiscard]] nlohmann::ordered_json quality_json(const MapResult& result);

/// The report's section on how good the map is.
/// \param quality_png  the picture of where (draw_quality_picture); may be empty
[[nodiscard]] std::string html_quality(const MapResult& result, std::string_view quality_png);

}  // namespace loopstone
