#pragma once

#include <cstddef>
#include <cstdint>

namespace loopstone {

/// Undoes the filters of a PNG picture in place (PNG specification, section 9).
/// \param rows  `height` rows, each one byte that names its filter and `row_bytes` bytes of pixels
/// \return whether all filters are known
[[nodiscard]] bool unfilter_png(std::uint8_t* rows, std::size_t row_bytes, std::size_t height,
                                std::size_t bytes_per_pixel);

}  // namespace loopstone
