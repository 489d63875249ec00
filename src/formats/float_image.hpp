#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "loopstone/formats/image.hpp"

namespace loopstone {

/// A picture of one 32-bit number a pixel; row 0 is the top.
struct FloatImage {
  int width = 0;
  int height = 0;
  std::vector<float> values{};
};

/// Portable float map of one channel ("Pf"), both byte orders (Debevec; netpbm's pfm(5)). The file
/// holds the bottom row first. The size of its scale must be 1: programs do not agree on whether
/// the numbers are to be multiplied by it.
[[nodiscard]] FloatImage decode_pfm(std::string_view bytes, const std::string& path_for_errors,
                                    const MemoryBudget& budget = {});

/// One-channel TIFF (Adobe, TIFF revision 6.0) of unsigned 16-bit numbers or of 32-bit floats;
/// strips or tiles; uncompressed, LZW, Deflate or PackBits; predictors of both kinds. The first
/// picture of the file.
///
/// Loopstone reads TIFF itself: what depth is stored in is a small part of the format, and the
/// usual library brings a dozen decoders along, one of them (JBIG-KIT) under a licence that would
/// bind the whole program. docs/file_readers.md has both side by side.
[[nodiscard]] std::variant<Image, FloatImage> decode_tiff(std::string_view bytes,
                                                          const std::string& path_for_errors,
                                                          const MemoryBudget& budget = {});
[[nodiscard]] bool is_tiff(std::string_view bytes);

}  // namespace loopstone
