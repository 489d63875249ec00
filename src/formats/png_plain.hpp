#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/formats/image.hpp"

namespace loopstone {

// Decodes what cameras and recorders write: PNG of 8 or 16 bits without palette, transparent colour
// or interlacing. Twice as fast as libpng, since libdeflate unpacks the whole picture at once.
//
// The result is nothing when the picture is of another kind or anything about it is not as it
// should be: libpng then has the word, and tells what is wrong.

/// Memory that is kept from picture to picture: asking the system for megabytes anew each time
/// costs as much as decoding.
struct PngScratch {
  std::string packed{};
  std::vector<std::uint8_t> rows{};
};

/// Pixels as they lie in a scratch.
struct PngRows {
  int width = 0;
  int height = 0;
  int channels = 0;
  int bytes_per_sample = 0;                 ///< 1, or 2 in big-endian order
  const std::uint8_t* first_row = nullptr;  ///< valid until the scratch is used again
  std::size_t stride = 0;                   ///< from row to row

  [[nodiscard]] std::size_t row_bytes() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(channels) *
           static_cast<std::size_t>(bytes_per_sample);
  }
  [[nodiscard]] const std::uint8_t* row(int index) const {
    return first_row + static_cast<std::size_t>(index) * stride;
  }
};

/// Throws DataError when the picture is more than the budget allows.
[[nodiscard]] std::optional<PngRows> unpack_plain_png(std::string_view bytes, PngScratch& scratch,
                                                      const std::string& path_for_errors = "image",
                                                      const MemoryBudget& budget = {});

/// Throws as the one above.
[[nodiscard]] std::optional<Image> decode_plain_png(std::string_view bytes,
                                                    const std::string& path_for_errors = "image",
                                                    const MemoryBudget& budget = {});

/// Every kind of PNG, by libpng. Throws DataError.
[[nodiscard]] Image decode_any_png(std::string_view bytes, const std::string& path_for_errors,
                                   const MemoryBudget& budget = {});

}  // namespace loopstone
