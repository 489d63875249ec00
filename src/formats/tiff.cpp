#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "formats/float_image.hpp"
#include "formats/picture_size.hpp"
#include "formats/tiff_head.hpp"

namespace loopstone {
namespace {

template <typename Number>
void turn_bytes(std::span<char> row) {
  for (std::size_t at = 0; at + sizeof(Number) <= row.size(); at += sizeof(Number)) {
    std::array<char, sizeof(Number)> raw;
    std::memcpy(raw.data(), row.data() + at, sizeof raw);
    std::reverse(raw.begin(), raw.end());
    std::memcpy(row.data() + at, raw.data(), sizeof raw);
  }
}

/// Each number is the difference to its left neighbour, modulo its width.
template <typename Number>
void sum_differences(std::span<char> row) {
  Number sum = 0;
  for (std::size_t at = 0; at + sizeof(Number) <= row.size(); at += sizeof(Number)) {
    Number value = 0;
    std::memcpy(&value, row.data() + at, sizeof value);
    sum = static_cast<Number>(sum + value);
    std::memcpy(row.data() + at, &sum, sizeof sum);
  }
}

/// Turns rows as they were unpacked into samples in the machine's byte order, the predictor undone.
class RowDecoder {
 public:
  explicit RowDecoder(const TiffHead& head) : head_(head) {}

  void decode(std::span<char> row) {
    if (head_.predictor == TiffPredictor::kFloatingPoint) return join_planes(row);
    if (head_.order != std::endian::native) {
      head_.is_float ? turn_bytes<std::uint32_t>(row) : turn_bytes<std::uint16_t>(row);
    }
    if (head_.predictor == TiffPredictor::kDifferences) {
      head_.is_float ? sum_differences<std::uint32_t>(row) : sum_differences<std::uint16_t>(row);
    }
  }

 private:
  /// Differences of bytes; then the highest bytes of all numbers stand first, whatever the byte
  /// order of the file. Source: Adobe Photoshop TIFF Technical Note 3.
  void join_planes(std::span<char> row) {
    sum_differences<std::uint8_t>(row);
    planes_.assign(row.begin(), row.end());
    const std::size_t numbers = row.size() / 4;
    const char* const plane = planes_.data();
    for (std::size_t i = 0; i < numbers; ++i) {
      std::array<char, 4> number{plane[i], plane[numbers + i], plane[2 * numbers + i],
                                 plane[3 * numbers + i]};
      if constexpr (std::endian::native == std::endian::little) {
        std::reverse(number.begin(), number.end());
      }
      std::memcpy(row.data() + 4 * i, number.data(), 4);
    }
  }

  const TiffHead& head_;
  std::vector<char> planes_{};
};

/// All samples, row by row from the top, to where they belong.
void decode_samples(std::string_view bytes, const TiffHead& head, char* to,
                    const std::string& path) {
  const std::size_t sample = head.bytes_per_sample();
  const std::size_t row_bytes = head.tile_width * sample;
  std::vector<char> tile(head.has_tiles ? row_bytes * head.tile_height : 0);
  RowDecoder decoder(head);
  for (std::size_t i = 0; i < head.tiles.size(); ++i) {
    const std::size_t column = i % head.tiles_across() * head.tile_width;
    const std::size_t first_row = i / head.tiles_across() * head.tile_height;
    const std::size_t columns = std::min(head.tile_width, head.width - column);
    const std::size_t rows = std::min(head.tile_height, head.height - first_row);
    // Strips are as wide as the picture and are unpacked where they belong.
    const std::span<char> plain =
        head.has_tiles ? std::span(tile) : std::span(to + first_row * row_bytes, rows * row_bytes);
    unpack_tiff(bytes.substr(head.tiles[i].offset, head.tiles[i].size), head.packing, plain, path);
    for (std::size_t row = 0; row < rows; ++row) {
      const std::span<char> decoded = plain.subspan(row * row_bytes, row_bytes);
      decoder.decode(decoded);
      if (head.has_tiles) {
        std::memcpy(to + ((first_row + row) * head.width + column) * sample, decoded.data(),
                    columns * sample);
      }
    }
  }
}

}  // namespace

bool is_tiff(std::string_view bytes) {
  using namespace std::string_view_literals;
  return bytes.starts_with("II*\0"sv) || bytes.starts_with("MM\0*"sv) ||
         bytes.starts_with("II+\0"sv) || bytes.starts_with("MM\0+"sv);
}

std::variant<Image, FloatImage> decode_tiff(std::string_view bytes,
                                            const std::string& path_for_errors,
                                            const MemoryBudget& budget) {
  const TiffHead head = parse_tiff_head(bytes, path_for_errors);
  for (const auto& [across, down] :
       {std::pair(head.width, head.height), std::pair(head.tile_width, head.tile_height)}) {
    require_picture(across, down, head.bytes_per_sample(), bytes.size(), budget, {path_for_errors});
  }
  const auto width = static_cast<int>(head.width);
  const auto height = static_cast<int>(head.height);
  if (head.is_float) {
    FloatImage image{width, height, std::vector<float>(head.width * head.height)};
    decode_samples(bytes, head, reinterpret_cast<char*>(image.values.data()), path_for_errors);
    return image;
  }
  Image image = make_image(width, height, 1, 2);
  decode_samples(bytes, head, reinterpret_cast<char*>(image.bytes.data()), path_for_errors);
  return image;
}

}  // namespace loopstone
