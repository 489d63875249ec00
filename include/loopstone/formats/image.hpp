#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/memory_budget.hpp"

namespace loopstone {

/// A picture as files hold it: row 0 is the top, samples interleaved (grey; grey, alpha; red,
/// green, blue; ... alpha).
struct Image {
  int width = 0;
  int height = 0;
  int channels = 1;                   ///< 1 to 4
  int bytes_per_sample = 1;           ///< 1, or 2 in the machine's byte order
  int max_value = 255;                ///< the sample that means white or opaque
  std::vector<std::uint8_t> bytes{};  ///< width * height * channels * bytes_per_sample

  [[nodiscard]] bool has_alpha() const { return channels == 2 || channels == 4; }
  [[nodiscard]] std::size_t sample_count() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
           static_cast<std::size_t>(channels);
  }
  [[nodiscard]] int sample(int row, int column, int channel = 0) const {
    const std::size_t i = (static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                           static_cast<std::size_t>(column)) *
                              static_cast<std::size_t>(channels) +
                          static_cast<std::size_t>(channel);
    if (bytes_per_sample == 1) return bytes[i];
    std::uint16_t value = 0;
    std::memcpy(&value, bytes.data() + 2 * i, sizeof value);
    return value;
  }
};

/// An image with all samples 0. Throws UsageError when a side is not positive or the whole too
/// large for memory.
[[nodiscard]] Image make_image(int width, int height, int channels, int bytes_per_sample = 1);

/// PNG of every kind: palettes and fewer than 8 bits are expanded to 8, 16 bits stay. Throws
/// DataError.
[[nodiscard]] Image decode_png(std::string_view bytes, const std::string& path_for_errors = "image",
                               const MemoryBudget& budget = {});
/// \param compression 0 (none) to 9 (smallest). 1 is several times faster than 6 and good enough
///                    for maps.
[[nodiscard]] std::string encode_png(const Image& image, int compression = 3);

/// Portable graymap and pixmap, plain and raw (P2, P3, P5, P6), with comments, maximum up to 65535.
/// Throws DataError.
[[nodiscard]] Image decode_pnm(std::string_view bytes, const std::string& path_for_errors = "image",
                               const MemoryBudget& budget = {});
/// Raw graymap (P5) without a comment; one channel, 8 bits.
[[nodiscard]] std::string encode_pgm(const Image& image);

/// JPEG of 8 bits, grey or colour, baseline or progressive; one that is cut off or damaged is
/// refused. Throws DataError.
[[nodiscard]] Image decode_jpeg(std::string_view bytes,
                                const std::string& path_for_errors = "image",
                                const MemoryBudget& budget = {});

/// PNG, JPEG or PNM, told apart by content. Throws DataError naming the formats that are
/// understood.
[[nodiscard]] Image decode_image(std::string_view bytes,
                                 const std::string& path_for_errors = "image",
                                 const MemoryBudget& budget = {});
[[nodiscard]] Image read_image(const std::string& path, const MemoryBudget& budget = {});
void write_png(const std::string& path, const Image& image, int compression = 3);

/// Writes a PNG of 8 bits a channel one row at a time, for pictures that do not fit into memory.
/// The file appears whole or not at all, also when `fill_row` throws. Throws DataError.
/// \param fill_row  puts width * channels samples of a row into the span, which holds the row
///                  before; rows come from the top, 0, down
void write_png_rows(const std::string& path, int width, int height, int channels,
                    const std::function<void(int row, std::span<std::uint8_t> samples)>& fill_row,
                    int compression = 3);

}  // namespace loopstone
