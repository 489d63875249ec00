#pragma once

#include <cstdint>
#include <string_view>

#include "loopstone/base/memory_budget.hpp"

namespace loopstone {

/// No picture is wider or higher [px].
inline constexpr std::uint64_t kMostPictureSide = std::uint64_t{1} << 20;

/// Asked before the pixels of a picture are allocated: a copy of them exists while they are
/// decoded.
/// \param pixel_bytes  of one, as it is held in memory
/// Throws DataError.
inline void require_picture(std::uint64_t width, std::uint64_t height, std::uint64_t pixel_bytes,
                            std::uint64_t file_bytes, const MemoryBudget& budget,
                            const Location& where) {
  constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 30;
  if (saturated_product(width, height) > kMostPixels) {
    throw DataError(where, "the picture would have more than 2^30 pixels");
  }
  budget.require(2 * width * height * pixel_bytes, file_bytes, Growth::kPicture, where);
}

}  // namespace loopstone
