#include "formats/tiff_head.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <optional>

#include "formats/picture_size.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

/// No packing of TIFF's shrinks more: Deflate 1032 to 1, LZW 1400 to 1.
constexpr std::size_t kMostShrinking = 2048;

enum Tag : unsigned {
  kWidth = 256,
  kHeight = 257,
  kBitsPerSample = 258,
  kCompression = 259,
  kPhotometric = 262,
  kFillOrder = 266,
  kStripOffsets = 273,
  kOrientation = 274,
  kSamplesPerPixel = 277,
  kRowsPerStrip = 278,
  kStripByteCounts = 279,
  kPredictor = 317,
  kTileWidth = 322,
  kTileHeight = 323,
  kTileOffsets = 324,
  kTileByteCounts = 325,
  kSampleFormat = 339,
};

/// The entries of a directory: lists of whole numbers by their tag.
class Directory {
 public:
  Directory(std::string_view bytes, const std::string& path) : bytes_(bytes), path_(path) {
    if (bytes.size() < 8 || (!bytes.starts_with("II") && !bytes.starts_with("MM"))) {
      fail("is no TIFF picture");
    }
    order_ = bytes[0] == 'I' ? std::endian::little : std::endian::big;
    const std::uint32_t version = number(2, 2);
    if (version == 43) fail("is a BigTIFF picture; write it as plain TIFF");
    if (version != 42) fail("is no TIFF picture");
    begin_ = number(4, 4);
    entries_ = number(begin_, 2);
    if (entries_ == 0) fail("is a damaged TIFF picture: its directory is empty");
  }

  [[nodiscard]] std::endian order() const { return order_; }

  /// All numbers of a tag; empty when the tag is not there.
  [[nodiscard]] std::vector<std::uint32_t> list(Tag tag) const {
    constexpr std::size_t kEntryBytes = 12;
    for (std::size_t i = 0; i < entries_; ++i) {
      const std::size_t entry = begin_ + 2 + i * kEntryBytes;
      if (number(entry, 2) == static_cast<std::uint32_t>(tag)) return read(entry, tag);
    }
    return {};
  }
  [[nodiscard]] std::optional<std::uint32_t> find(Tag tag) const {
    const auto numbers = list(tag);
    return numbers.empty() ? std::nullopt : std::optional(numbers.front());
  }
  [[nodiscard]] std::uint32_t require(Tag tag, const char* name) const {
    const auto value = find(tag);
    if (!value) fail(fmt::format("is a damaged TIFF picture: it does not say its {}", name));
    return *value;
  }
  [[noreturn]] void fail(const std::string& reason) const { throw DataError({path_}, reason); }

 private:
  [[nodiscard]] std::uint32_t number(std::size_t at, std::size_t size) const {
    if (at > bytes_.size() || bytes_.size() - at < size) {
      fail(fmt::format("is a damaged TIFF picture: it ends before byte {}", at + size));
    }
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t from = order_ == std::endian::big ? at + i : at + size - 1 - i;
      value = (value << 8U) | static_cast<std::uint8_t>(bytes_[from]);
    }
    return value;
  }

  [[nodiscard]] std::vector<std::uint32_t> read(std::size_t entry, Tag tag) const {
    constexpr std::uint32_t kShort = 3;
    constexpr std::uint32_t kLong = 4;
    const std::uint32_t type = number(entry + 2, 2);
    const std::size_t count = number(entry + 4, 4);
    if (type != kShort && type != kLong) {
      fail(fmt::format("is a damaged TIFF picture: tag {} is of type {}", static_cast<int>(tag),
                       type));
    }
    const std::size_t size = type == kShort ? 2 : 4;
    const std::size_t at = count * size <= 4 ? entry + 8 : number(entry + 8, 4);
    if (at > bytes_.size() || (bytes_.size() - at) / size < count) {
      fail(fmt::format("is a damaged TIFF picture: tag {} lies beyond its end",
                       static_cast<int>(tag)));
    }
    std::vector<std::uint32_t> numbers(count);
    for (std::size_t i = 0; i < count; ++i) numbers[i] = number(at + i * size, size);
    return numbers;
  }

  std::string_view bytes_;
  const std::string& path_;
  std::endian order_ = std::endian::little;
  std::size_t begin_ = 0;
  std::size_t entries_ = 0;
};

std::size_t side(const Directory& directory, Tag tag, const char* name) {
  const std::uint32_t value = directory.require(tag, name);
  if (value == 0 || value > kMostPictureSide) {
    directory.fail(fmt::format("is a damaged TIFF picture: its {} is {}", name, value));
  }
  return value;
}

/// One channel of 16-bit numbers or 32-bit floats, black is 0, top row first: nothing else can be
/// depth.
void check_samples(const Directory& directory, TiffHead& head) {
  const std::uint32_t channels = directory.find(kSamplesPerPixel).value_or(1);
  const std::uint32_t bits = directory.find(kBitsPerSample).value_or(1);
  const std::uint32_t format = directory.find(kSampleFormat).value_or(1);
  head.is_float = format == 3 && bits == 32;
  if (channels != 1 || !(head.is_float || (format == 1 && bits == 16))) {
    const char* const kind = format == 1   ? "unsigned numbers"
                             : format == 2 ? "signed numbers"
                             : format == 3 ? "floats"
                                           : "values of another kind";
    directory.fail(fmt::format(
        "is a TIFF picture with {} channels of {}-bit {}; depth is one channel of unsigned 16-bit "
        "numbers or of metres as 32-bit floats",
        channels, bits, kind));
  }
  if (directory.find(kPhotometric).value_or(1) != 1) {
    directory.fail("is a TIFF picture in which black is not 0: no depth");
  }
  if (directory.find(kOrientation).value_or(1) != 1 ||
      directory.find(kFillOrder).value_or(1) != 1) {
    directory.fail("is a TIFF picture that is turned or has its bits reversed; write it anew");
  }
}

TiffPacking packing_of(const Directory& directory) {
  const std::uint32_t compression = directory.find(kCompression).value_or(1);
  switch (compression) {
    case 1:
      return TiffPacking::kNone;
    case 5:
      return TiffPacking::kLzw;
    case 8:
    case 32946:
      return TiffPacking::kDeflate;
    case 32773:
      return TiffPacking::kPackBits;
    default:
      directory.fail(fmt::format(
          "is a TIFF picture packed by method {}; write it without compression, or with LZW, "
          "Deflate or PackBits",
          compression));
  }
}

TiffPredictor predictor_of(const Directory& directory, const TiffHead& head) {
  const std::uint32_t predictor = directory.find(kPredictor).value_or(1);
  if (predictor == 1) return TiffPredictor::kNone;
  if (predictor == 2) return TiffPredictor::kDifferences;
  if (predictor == 3 && head.is_float) return TiffPredictor::kFloatingPoint;
  directory.fail(fmt::format("is a TIFF picture with predictor {}, which is not known", predictor));
}

void read_tiles(const Directory& directory, std::size_t file_size, TiffHead& head) {
  head.has_tiles = directory.find(kTileWidth).has_value();
  if (head.has_tiles) {
    head.tile_width = side(directory, kTileWidth, "tiles' width");
    head.tile_height = side(directory, kTileHeight, "tiles' height");
  } else {
    const std::uint32_t rows =
        directory.find(kRowsPerStrip).value_or(static_cast<std::uint32_t>(kMostPictureSide));
    head.tile_width = head.width;
    head.tile_height = rows == 0 || rows > head.height ? head.height : rows;
  }
  const auto offsets = directory.list(head.has_tiles ? kTileOffsets : kStripOffsets);
  const auto sizes = directory.list(head.has_tiles ? kTileByteCounts : kStripByteCounts);
  const std::size_t tiles = head.tiles_across() * head.tiles_down();
  if (offsets.size() < tiles || sizes.size() < tiles) {
    directory.fail(
        fmt::format("is a damaged TIFF picture: it needs {} strips or tiles and lists {}", tiles,
                    std::min(offsets.size(), sizes.size())));
  }
  std::size_t packed_bytes = 0;
  head.tiles.reserve(tiles);
  for (std::size_t i = 0; i < tiles; ++i) {
    if (offsets[i] > file_size || file_size - offsets[i] < sizes[i]) {
      directory.fail("is a damaged TIFF picture: its pixels lie beyond its end; it was cut off");
    }
    head.tiles.push_back({offsets[i], sizes[i]});
    packed_bytes += sizes[i];
  }
  // Many tiles of the same bytes would make a large picture of a small file.
  if (packed_bytes > file_size) {
    directory.fail("is a damaged TIFF picture: its strips or tiles overlap");
  }
  const std::size_t bytes = tiles * head.tile_width * head.tile_height * head.bytes_per_sample();
  if (bytes / kMostShrinking > packed_bytes) {
    directory.fail("is a damaged TIFF picture: it claims more pixels than its data can hold");
  }
}

}  // namespace

TiffHead parse_tiff_head(std::string_view bytes, const std::string& path) {
  const Directory directory(bytes, path);
  TiffHead head;
  head.order = directory.order();
  head.width = side(directory, kWidth, "width");
  head.height = side(directory, kHeight, "height");
  check_samples(directory, head);
  head.packing = packing_of(directory);
  head.predictor = predictor_of(directory, head);
  read_tiles(directory, bytes.size(), head);
  return head;
}

}  // namespace loopstone
