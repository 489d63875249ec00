#include "formats/png_plain.hpp"

#include <libdeflate.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>

#include "formats/picture_size.hpp"
#include "formats/png_unfilter.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kMostExpansion = 1032;  // of Deflate

std::uint32_t big_endian_32(std::string_view bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = (value << 8U) | static_cast<std::uint8_t>(bytes[i]);
  return value;
}

struct PlainHead {
  std::size_t width = 0;
  std::size_t height = 0;
  int channels = 0;
  int bytes_per_sample = 0;

  [[nodiscard]] std::size_t bytes_per_pixel() const {
    return static_cast<std::size_t>(channels) * static_cast<std::size_t>(bytes_per_sample);
  }
  [[nodiscard]] std::size_t row_bytes() const { return width * bytes_per_pixel(); }
};

std::optional<PlainHead> parse_head(std::string_view data) {
  if (data.size() != 13) return std::nullopt;
  PlainHead head{big_endian_32(data), big_endian_32(data.substr(4)), 0, data[8] == 16 ? 2 : 1};
  const bool plain_depth = data[8] == 8 || data[8] == 16;
  const bool plain_storage = data[10] == 0 && data[11] == 0 && data[12] == 0;
  if (data[9] == 0) head.channels = 1;
  if (data[9] == 2) head.channels = 3;
  if (data[9] == 4) head.channels = 2;
  if (data[9] == 6) head.channels = 4;
  const bool sane_size = head.width > 0 && head.height > 0 && head.width <= kMostPictureSide &&
                         head.height <= kMostPictureSide;
  if (!plain_depth || !plain_storage || head.channels == 0 || !sane_size) return std::nullopt;
  return head;
}

/// The pieces of a PNG file one after the other, while their checksums hold.
class Chunks {
 public:
  explicit Chunks(std::string_view bytes) : rest_(bytes) {}

  struct Chunk {
    std::string_view type;
    std::string_view data;
  };
  std::optional<Chunk> next() {
    constexpr std::size_t kAround = 12;  // length, type, checksum
    if (rest_.size() < kAround) return std::nullopt;
    const std::size_t size = big_endian_32(rest_);
    if (rest_.size() - kAround < size) return std::nullopt;
    const std::string_view checked = rest_.substr(4, 4 + size);
    if (libdeflate_crc32(0, checked.data(), checked.size()) !=
        big_endian_32(rest_.substr(8 + size))) {
      return std::nullopt;
    }
    rest_.remove_prefix(kAround + size);
    return Chunk{checked.substr(0, 4), checked.substr(4)};
  }

 private:
  std::string_view rest_;
};

struct PlainPng {
  PlainHead head{};
  std::string_view packed{};
};

/// \param joined  takes the packed pixels when they come in several pieces
std::optional<PlainPng> split(std::string_view bytes, std::string& joined) {
  constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);
  if (!bytes.starts_with(kSignature)) return std::nullopt;
  Chunks chunks(bytes.substr(kSignature.size()));
  const auto first = chunks.next();
  if (!first || first->type != "IHDR") return std::nullopt;
  const auto head = parse_head(first->data);
  if (!head) return std::nullopt;
  PlainPng png{*head, {}};
  std::size_t pieces = 0;
  std::string_view last_type = first->type;
  while (const auto chunk = chunks.next()) {
    if (chunk->type == "IEND") return png;
    if (chunk->type == "IDAT") {
      if (++pieces == 1) {
        png.packed = chunk->data;
      } else {
        if (last_type != "IDAT") return std::nullopt;
        if (pieces == 2) joined.assign(png.packed);
        joined += chunk->data;
        png.packed = joined;
      }
    } else {
      const bool must_be_understood = chunk->type[0] >= 'A' && chunk->type[0] <= 'Z';
      if (must_be_understood || chunk->type == "tRNS") return std::nullopt;
    }
    last_type = chunk->type;
  }
  return std::nullopt;
}

bool unpack(std::string_view packed, std::uint8_t* to, std::size_t size) {
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)>
      decompressor(libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  std::size_t unpacked = 0;
  return decompressor != nullptr &&
         libdeflate_zlib_decompress(decompressor.get(), packed.data(), packed.size(), to, size,
                                    &unpacked) == LIBDEFLATE_SUCCESS &&
         unpacked == size;
}

}  // namespace

std::optional<PngRows> unpack_plain_png(std::string_view bytes, PngScratch& scratch,
                                        const std::string& path_for_errors,
                                        const MemoryBudget& budget) {
  const auto png = split(bytes, scratch.packed);
  if (!png) return std::nullopt;
  const PlainHead& head = png->head;
  const std::size_t stride = head.row_bytes() + 1;  // the first byte of a row names its filter
  const std::size_t size = head.height * stride;
  if (size / kMostExpansion > bytes.size()) return std::nullopt;
  require_picture(head.width, head.height, head.bytes_per_pixel(), bytes.size(), budget,
                  {path_for_errors});
  if (scratch.rows.size() < size) scratch.rows.resize(size);
  if (!unpack(png->packed, scratch.rows.data(), size) ||
      !unfilter_png(scratch.rows.data(), head.row_bytes(), head.height, head.bytes_per_pixel())) {
    return std::nullopt;
  }
  return PngRows{static_cast<int>(head.width), static_cast<int>(head.height), head.channels,
                 head.bytes_per_sample,        scratch.rows.data() + 1,       stride};
}

std::optional<Image> decode_plain_png(std::string_view bytes, const std::string& path_for_errors,
                                      const MemoryBudget& budget) {
  PngScratch scratch;
  const auto rows = unpack_plain_png(bytes, scratch, path_for_errors, budget);
  if (!rows) return std::nullopt;
  Image image = make_image(rows->width, rows->height, rows->channels, rows->bytes_per_sample);
  const std::size_t row_bytes = rows->row_bytes();
  std::uint8_t* to = image.bytes.data();
  for (int row = 0; row < rows->height; ++row, to += row_bytes) {
    const std::uint8_t* const from = rows->row(row);
    if (rows->bytes_per_sample == 1 || std::endian::native == std::endian::big) {
      std::memcpy(to, from, row_bytes);
    } else {
      for (std::size_t i = 0; i < row_bytes; i += 2) {
        to[i] = from[i + 1];
        to[i + 1] = from[i];
      }
    }
  }
  return image;
}

}  // namespace loopstone
