#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "loopstone/mapping/floor_texture.hpp"

namespace loopstone {

/// Every figure of a texture, units in the key names.
[[nodiscard]] nlohmann::ordered_json texture_json(const FloorTexture& texture);

/// The section of a report, with the picture of the floor.
[[nodiscard]] std::string html_texture(const FloorTexture& texture, std::string_view picture_png);

}  // namespace loopstone
