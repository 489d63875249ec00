#pragma once

#include <optional>
#include <string>

#include "loopstone/formats/image.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/mapping/filter_mask.hpp"

namespace loopstone {

/// A mask as nav2's map_server reads it in mode raw: a pixel is the value of its cell, the top row
/// the one with the largest y.
[[nodiscard]] Image mask_image(const FilterMask& mask);
/// The file beside it.
[[nodiscard]] std::string format_mask_yaml(const GridFrame& frame, const std::string& image_name);

/// The parameters by which nav2 reads the masks of a map: of the servers of masks and of what they
/// mean, and of the filters in the global costmap.
/// \param keep_out, speed  those that there are; null: none
[[nodiscard]] std::string format_nav2_filters(const FilterMask* keep_out, const FilterMask* speed);

}  // namespace loopstone
