// libtiff (https://libtiff.gitlab.io/libtiff/) on depth pictures: reads them as ours does, into one
// array of 16-bit numbers or floats, and refuses what can't be depth.
//   tiff_files make FOLDER WIDTH HEIGHT    writes a picture in every variant
// and what ../reader_trials.hpp tells.

#include <tiffio.h>

#include <algorithm>
#include <memory>

#include "../reader_trials.hpp"

namespace {

using namespace loopstone::bench;
using Tiff = std::unique_ptr<TIFF, void (*)(TIFF*)>;

int keep_quiet(TIFF*, void*, const char*, const char*, va_list) { return 1; }

[[noreturn]] void fail(const char* reason) { throw std::runtime_error(reason); }

Tiff open(const std::string& path) {
  TIFFOpenOptions* const options = TIFFOpenOptionsAlloc();
  TIFFOpenOptionsSetMaxSingleMemAlloc(options, kMostValueBytes);
  TIFFOpenOptionsSetErrorHandlerExtR(options, keep_quiet, nullptr);
  TIFFOpenOptionsSetWarningHandlerExtR(options, keep_quiet, nullptr);
  Tiff tiff(TIFFOpenExt(path.c_str(), "r", options), TIFFClose);
  TIFFOpenOptionsFree(options);
  if (!tiff) fail("is no TIFF picture that libtiff opens");
  return tiff;
}

struct Head {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool is_float = false;
};

Head head_of(TIFF* tiff) {
  Head head;
  std::uint16_t channels = 1;
  std::uint16_t bits = 1;
  std::uint16_t format = 1;
  std::uint16_t photometric = 1;
  std::uint16_t orientation = 1;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &head.width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &head.height);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &channels);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
  TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_ORIENTATION, &orientation);
  head.is_float = format == SAMPLEFORMAT_IEEEFP && bits == 32;
  const bool is_depth = channels == 1 && photometric == PHOTOMETRIC_MINISBLACK &&
                        orientation == ORIENTATION_TOPLEFT &&
                        (head.is_float || (format == SAMPLEFORMAT_UINT && bits == 16));
  if (!is_depth) fail("is no depth picture");
  if (head.width == 0 || head.height == 0) fail("has no pixels");
  require_value_bytes(std::uint64_t{head.width} * head.height, head.is_float ? 4 : 2);
  return head;
}

void read_strips(TIFF* tiff, const Head& head, std::uint8_t* to) {
  const std::size_t row_bytes = std::size_t{head.width} * (head.is_float ? 4 : 2);
  if (static_cast<std::size_t>(TIFFScanlineSize(tiff)) != row_bytes) fail("its rows make no sense");
  std::uint32_t rows = head.height;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &rows);
  rows = std::min(rows, head.height);
  if (rows == 0) fail("has strips without rows");
  for (std::uint32_t row = 0; row < head.height; row += rows) {
    const auto bytes = static_cast<tmsize_t>(row_bytes * std::min(rows, head.height - row));
    if (TIFFReadEncodedStrip(tiff, TIFFComputeStrip(tiff, row, 0), to + row * row_bytes, bytes) !=
        bytes) {
      fail("a strip does not unpack");
    }
  }
}

void read_tiles(TIFF* tiff, const Head& head, std::uint8_t* to) {
  const std::size_t sample = head.is_float ? 4 : 2;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &width);
  TIFFGetField(tiff, TIFFTAG_TILELENGTH, &height);
  if (width == 0 || height == 0) fail("has tiles without pixels");
  require_value_bytes(std::uint64_t{width} * height, sample);
  std::vector<std::uint8_t> tile(std::size_t{width} * height * sample);
  if (TIFFTileSize(tiff) != static_cast<tmsize_t>(tile.size())) fail("its tiles make no sense");
  for (std::uint32_t row = 0; row < head.height; row += height) {
    for (std::uint32_t column = 0; column < head.width; column += width) {
      const auto index = TIFFComputeTile(tiff, column, row, 0, 0);
      const auto bytes = static_cast<tmsize_t>(tile.size());
      if (TIFFReadEncodedTile(tiff, index, tile.data(), bytes) != bytes) {
        fail("a tile does not unpack");
      }
      const std::size_t columns = std::min(width, head.width - column);
      for (std::uint32_t i = 0; i < std::min(height, head.height - row); ++i) {
        std::memcpy(to + (std::size_t{row + i} * head.width + column) * sample,
                    tile.data() + std::size_t{i} * width * sample, columns * sample);
      }
    }
  }
}

template <typename Sample>
void read_samples(TIFF* tiff, const Head& head, ValueDigest* digest) {
  std::vector<Sample> values(std::size_t{head.width} * head.height);
  auto* const to = reinterpret_cast<std::uint8_t*>(values.data());
  TIFFIsTiled(tiff) != 0 ? read_tiles(tiff, head, to) : read_strips(tiff, head, to);
  if (digest == nullptr) return;
  digest->add_sizes("", head.height, head.width);
  digest->add_all(values);
}

void read_tiff(const std::string& path, ValueDigest* digest) {
  const Tiff tiff = open(path);
  const Head head = head_of(tiff.get());
  head.is_float ? read_samples<float>(tiff.get(), head, digest)
                : read_samples<std::uint16_t>(tiff.get(), head, digest);
}

// What is written.

struct Variant {
  const char* name;
  char type;  ///< 'u' of 16 bits, 'f' of 32, 'd' of 64, 'b' of 8
  std::uint16_t compression = COMPRESSION_NONE;
  std::uint16_t predictor = 1;
  bool has_tiles = false;
  const char* mode = "wl";
};

const std::vector<Variant> kVariants{
    {"numbers_plain", 'u'},
    {"numbers_plain_tiles", 'u', COMPRESSION_NONE, 1, true},
    {"numbers_plain_big_endian", 'u', COMPRESSION_NONE, 1, false, "wb"},
    {"numbers_lzw", 'u', COMPRESSION_LZW},
    {"numbers_lzw_differences", 'u', COMPRESSION_LZW, 2},
    {"numbers_lzw_differences_big_endian", 'u', COMPRESSION_LZW, 2, false, "wb"},
    {"numbers_deflate", 'u', COMPRESSION_ADOBE_DEFLATE},
    {"numbers_deflate_differences", 'u', COMPRESSION_ADOBE_DEFLATE, 2},
    {"numbers_deflate_tiles", 'u', COMPRESSION_DEFLATE, 2, true},
    {"numbers_packbits", 'u', COMPRESSION_PACKBITS},
    {"numbers_bigtiff", 'u', COMPRESSION_LZW, 1, false, "w8"},
    {"numbers_zstd", 'u', COMPRESSION_ZSTD, 2},
    {"numbers_lzma", 'u', COMPRESSION_LZMA, 2},
    {"numbers_lerc", 'u', COMPRESSION_LERC},
    {"metres_plain", 'f'},
    {"metres_plain_big_endian", 'f', COMPRESSION_NONE, 1, false, "wb"},
    {"metres_lzw", 'f', COMPRESSION_LZW},
    {"metres_lzw_float_predictor", 'f', COMPRESSION_LZW, 3},
    {"metres_deflate", 'f', COMPRESSION_ADOBE_DEFLATE},
    {"metres_deflate_differences", 'f', COMPRESSION_ADOBE_DEFLATE, 2},
    {"metres_deflate_float_predictor", 'f', COMPRESSION_ADOBE_DEFLATE, 3},
    {"metres_deflate_float_predictor_tiles", 'f', COMPRESSION_ADOBE_DEFLATE, 3, true},
    {"metres_packbits", 'f', COMPRESSION_PACKBITS},
    {"metres_bigtiff", 'f', COMPRESSION_ADOBE_DEFLATE, 3, true, "w8"},
    {"metres_zstd", 'f', COMPRESSION_ZSTD, 3},
    {"metres_lerc", 'f', COMPRESSION_LERC},
};

/// A slanted floor, a box, noise of some millimetres, no measurement here and there [mm].
std::vector<std::uint16_t> depth_picture(std::uint32_t width, std::uint32_t height) {
  std::vector<std::uint16_t> depth;
  std::uint32_t state = 1;
  for (std::uint32_t row = 0; row < height; ++row) {
    for (std::uint32_t column = 0; column < width; ++column) {
      state = state * 1664525U + 1013904223U;
      const bool is_box = row > height / 3 && row < height / 2 && column > width / 2;
      const std::uint32_t mm = (is_box ? 1800 : 4000 - 2000 * row / height) + (state >> 29U);
      depth.push_back(static_cast<std::uint16_t>((state >> 16U) % 23 == 0 ? 0 : mm));
    }
  }
  return depth;
}

template <typename Sample>
void write_samples(TIFF* tiff, const Variant& variant, const std::vector<Sample>& values,
                   std::uint32_t width, std::uint32_t height) {
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, static_cast<int>(8 * sizeof(Sample)));
  if (!variant.has_tiles) {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(tiff, 0));
    std::vector<Sample> row(width);
    for (std::uint32_t i = 0; i < height; ++i) {
      // Copied: libtiff turns the bytes of what it is given.
      std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(i) * width, width, row.begin());
      if (TIFFWriteScanline(tiff, row.data(), i, 0) != 1) fail("a row can't be written");
    }
    return;
  }
  constexpr std::uint32_t kSide = 64;
  TIFFSetField(tiff, TIFFTAG_TILEWIDTH, kSide);
  TIFFSetField(tiff, TIFFTAG_TILELENGTH, kSide);
  for (std::uint32_t row = 0; row < height; row += kSide) {
    for (std::uint32_t column = 0; column < width; column += kSide) {
      std::vector<Sample> tile(std::size_t{kSide} * kSide);
      for (std::uint32_t i = 0; i < std::min(kSide, height - row); ++i) {
        for (std::uint32_t j = 0; j < std::min(kSide, width - column); ++j) {
          tile[i * kSide + j] = values[std::size_t{row + i} * width + column + j];
        }
      }
      if (TIFFWriteTile(tiff, tile.data(), column, row, 0, 0) < 0) fail("a tile can't be written");
    }
  }
}

void write_variant(const std::string& folder, const Variant& variant, std::uint32_t width,
                   std::uint32_t height) {
  const std::string path = folder + "/" + variant.name + ".tif";
  const Tiff tiff(TIFFOpen(path.c_str(), variant.mode), TIFFClose);
  if (!tiff) fail("can't be written");
  TIFFSetField(tiff.get(), TIFFTAG_IMAGEWIDTH, width);
  TIFFSetField(tiff.get(), TIFFTAG_IMAGELENGTH, height);
  TIFFSetField(tiff.get(), TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff.get(), TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff.get(), TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff.get(), TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
  TIFFSetField(tiff.get(), TIFFTAG_COMPRESSION, static_cast<int>(variant.compression));
  if (variant.predictor != 1) {
    TIFFSetField(tiff.get(), TIFFTAG_PREDICTOR, static_cast<int>(variant.predictor));
  }
  const bool is_float = variant.type == 'f';
  TIFFSetField(tiff.get(), TIFFTAG_SAMPLEFORMAT,
               is_float ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT);
  const auto depth = depth_picture(width, height);
  if (!is_float) return write_samples(tiff.get(), variant, depth, width, height);
  std::vector<float> metres;
  for (const std::uint16_t mm : depth) metres.push_back(0.001F * static_cast<float>(mm));
  write_samples(tiff.get(), variant, metres, width, height);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 5 && std::string_view(argv[1]) == "make") {
    for (const Variant& variant : kVariants) {
      write_variant(argv[2], variant, static_cast<std::uint32_t>(std::stoul(argv[3])),
                    static_cast<std::uint32_t>(std::stoul(argv[4])));
    }
    return 0;
  }
  return reader_main(argc, argv, {{".tif", read_tiff}});
}
