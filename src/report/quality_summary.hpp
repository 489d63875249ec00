#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// The object "quality" of summary.json.
[[nodiscard]] nlohmann::ordered_json quality_json(const MapResult& result);

/// The report's section on how good the map is.
/// \param quality_png  the picture of where (draw_quality_picture); may be empty
[[nodiscard]] std::string html_quality(const MapResult& result, std::string_view quality_png);

}  // namespace loopstone
