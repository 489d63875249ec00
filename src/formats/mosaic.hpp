#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "loopstone/sensor/rgbd_images.hpp"

// Pictures of sensors that see one colour a pixel (Bayer's mosaic).

namespace loopstone {

/// Where red stands in each square of 2 x 2 pixels; blue stands diagonally to it.
struct MosaicOrder {
  int red_column = 0;
  int red_row = 0;
};

/// Of "bayer_rggb8" and its like; nothing for all else.
[[nodiscard]] std::optional<MosaicOrder> mosaic_order(std::string_view encoding);

/// The mean of the nearest pixels of each colour (bilinear interpolation).
/// \param row_at  the bytes of a row
[[nodiscard]] ColourImage fill_mosaic(const std::function<const std::uint8_t*(int)>& row_at,
                                      int width, int height, const MosaicOrder& order);

}  // namespace loopstone
