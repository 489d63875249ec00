#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace loopstone {

enum class TiffPacking { kNone, kLzw, kDeflate, kPackBits };
enum class TiffPredictor { kNone, kDifferences, kFloatingPoint };

/// Part of the bytes of a TIFF file.
struct TiffSpan {
  std::size_t offset = 0;
  std::size_t size = 0;
};

/// What the first directory of a TIFF file says of a picture with one channel. A strip is a tile as
/// wide as the picture.
struct TiffHead {
  std::endian order = std::endian::little;
  std::size_t width = 0;
  std::size_t height = 0;
  bool is_float = false;  ///< 32-bit floats; else unsigned numbers of 16 bits
  TiffPacking packing = TiffPacking::kNone;
  TiffPredictor predictor = TiffPredictor::kNone;
  bool has_tiles = false;  ///< tiles are always whole, strips end with the picture
  std::size_t tile_width = 0;
  std::size_t tile_height = 0;
  std::vector<TiffSpan> tiles{};  ///< row by row, all within the file

  [[nodiscard]] std::size_t bytes_per_sample() const { return is_float ? 4 : 2; }
  [[nodiscard]] std::size_t tiles_across() const { return (width + tile_width - 1) / tile_width; }
  [[nodiscard]] std::size_t tiles_down() const { return (height + tile_height - 1) / tile_height; }
};

/// Throws DataError that says what is damaged or not understood.
[[nodiscard]] TiffHead parse_tiff_head(std::string_view bytes, const std::string& path);

/// Fills `to` from packed bytes. Throws DataError when they hold less.
void unpack_tiff(std::string_view packed, TiffPacking packing, std::span<char> to,
                 const std::string& path);

}  // namespace loopstone
