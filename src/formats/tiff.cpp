#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
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
void turn_bytes(std::string& row) {
  for (std::size_t at = 0; at + sizeof(Number) <= row.size(); at += sizeof(Number)) {
    std::reverse(row.begin() + static_cast<std::ptrdiff_t>(at),
                 row.begin() + static_cast<std::ptrdiff_t>(at + sizeof(Number)));
  }
}

/// Each number is the difference to its left neighbour, modulo its width.
template <typename Number>
void sum_differences(std::string& row) {
  Number sum = 0;
  for (std::size_t at = 0; at + sizeof(Number) <= row.size(); at += sizeof(Number)) {
    Number value = 0;
    std::memcpy(&value, row.data() + at, sizeof value);
    sum = static_cast<Number>(sum + value);
    std::memcpy(row.data() + at, &sum, sizeof sum);
  }
}

/// Differences of bytes; then the highest bytes of all numbers stand first, whatever the byte order
/// of the file. Source: Adobe Photoshop TIFF Technical Note 3.
std::string floats_from_planes(std::string row) {
  sum_differences<std::uint8_t>(row);
  const std::size_t numbers = row.size() / 4;
  std::string floats(row.size(), '\0');
  for (std::size_t i = 0; i < numbers; ++i) {
    for (std::size_t byte = 0; byte < 4; ++byte) {
      const std::size_t plane = std::endian::native == std::endian::little ? 3 - byte : byte;
      floats[4 * i + byte] = row[plane * numbers + i];
    }
  }
  return floats;
}

/// A row of a tile in the machine's byte order, the predictor undone.
std::string decode_row(std::string row, const TiffHead& head) {
  if (head.predictor == TiffPredictor::kFloatingPoint) return floats_from_planes(std::move(row));
  if (head.order != std::endian::native) {
    head.is_float ? turn_bytes<std::uint32_t>(row) : turn_bytes<std::uint16_t>(row);
  }
  if (head.predictor == TiffPredictor::kDifferences) {
    head.is_float ? sum_differences<std::uint32_t>(row) : sum_differences<std::uint16_t>(row);
  }
  return row;
}

/// All samples, row by row from the top, to where they belong.
void decode_samples(std::string_view bytes, const TiffHead& head, char* to,
                    const std::string& path) {
  const std::size_t sample = head.bytes_per_sample();
  for (std::size_t tile = 0; tile < head.tiles.size(); ++tile) {
    const std::size_t column = tile % head.tiles_across() * head.tile_width;
    const std::size_t first_row = tile / head.tiles_across() * head.tile_height;
    const std::size_t columns = std::min(head.tile_width, head.width - column);
    const std::size_t rows = std::min(head.tile_height, head.height - first_row);
    const std::size_t row_bytes = head.tile_width * sample;
    const std::string plain =
        unpack_tiff(bytes.substr(head.tiles[tile].offset, head.tiles[tile].size), head.packing,
                    row_bytes * (head.has_tiles ? head.tile_height : rows), path);
    for (std::size_t row = 0; row < rows; ++row) {
      const std::string decoded = decode_row(plain.substr(row * row_bytes, row_bytes), head);
      std::memcpy(to + ((first_row + row) * head.width + column) * sample, decoded.data(),
                  columns * sample);
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
